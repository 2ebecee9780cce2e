"""The faults of files and input: damage that HDF5 would see, the child that examines, verify, sizes without end."""

from __future__ import annotations

from tests.faults import ASKED, KEPT, READING, SCHEMA, Mutant

__all__ = ["FILES"]

SEALED, SEAL, GUARD = "tests/test_seal.py", "floquet/store/seal.py", "floquet/store/guard.py"
CHECKING = "floquet/checking.py"

STUDY, PROOFS = "tests/test_study.py", "tests/test_proofs.py"
SHARED, DASK = "floquet/study/workers.py", "tests/test_cluster.py"

FILES: tuple[Mutant, ...] = (
    Mutant(
        "rows of a database that was replaced",
        "floquet/study/running.py",
        "if there is not None and there.digest != store.data_digest(out):",
        "if False:",
        "tests/test_extend.py -k at_once_take",
    ),
    Mutant(
        "replaced while it is read",
        "floquet/study/extending.py",
        "if file.data_digest() != self.digest:",
        "if False:",
        "tests/test_extend.py -k at_once_take",
    ),
    Mutant(
        "limits lost by extending",
        "floquet/study/extending.py",
        "            _refuse_lost_limits(file, plan)\n",
        "            pass\n",
        "tests/test_extend.py -k has_no_row_there",
    ),
    Mutant(
        "columns lost by extending",
        "floquet/study/extending.py",
        "        _refuse_lost_columns(file, study)\n",
        "",
        "tests/test_extend.py -k has_no_row_there",
    ),
    Mutant(
        "merged rows of this engine",
        "floquet/study/merging.py",
        'int(first.attributes["engine_version"]),',
        "",
        f"{STUDY} -k keep_the_number",
    ),
    Mutant(
        "packed rows of this engine",
        "floquet/study/packing.py",
        "*told, _engine(parts, everything)",
        "*told",
        f"{STUDY} -k keep_the_number",
    ),
    Mutant(
        "living leftovers removed",
        "floquet/store/files.py",
        "fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)",
        "pass",
        f"{STUDY} -k those_that_live",
    ),
    Mutant(
        "what came meanwhile replaced",
        "floquet/store/files.py",
        "        if not replace:\n",
        "        if False:\n",
        f"{STUDY} -k those_that_live",
    ),
    Mutant(
        "everybody may read it",
        "floquet/store/files.py",
        "shutil.copymode(path, temporary)",
        "pass",
        f"{STUDY} -k those_that_live",
    ),
    Mutant(
        "journals believed",
        "floquet/study/folder.py",
        ' or about.get("digest") != _digest(about)',
        "",
        f"{STUDY} -k journal_that_was",
    ),
    Mutant(
        "numbers packed in another way",
        READING,
        "            if self.sealed:\n                raise\n",
        "            raise\n",
        f"{SEALED} -k another_way",
    ),
    Mutant(
        "names of rotors that stand twice",
        "floquet/study/merging.py",
        "design, piece = values.tobytes()",
        "design, piece = str(file.names).encode() + values.tobytes()",
        f"{STUDY} -k another_name",
    ),
    Mutant(
        "notes removed with the parts", "floquet/study/folder.py", '"points-*.h5", ', '"*", ', f"{STUDY} -k others_put"
    ),
    Mutant(
        "other endings taken for databases",
        "floquet/study/folder.py",
        "if path.suffix.lower() in OTHER_FORMATS:",
        "if False:",
        "tests/test_cli.py -k run_resume",
    ),
    Mutant(
        "bytes not by the sample",
        "floquet/study/estimating.py",
        "        size = sum(s.size * counts[t] for t, s in found.items())\n",
        "",
        "tests/test_cli.py -k dry",
    ),
    Mutant(
        "what is copied counted",
        "floquet/study/estimating.py",
        "copied = there.points",
        "copied = 0",
        "tests/test_cli.py -k dry",
    ),
    Mutant(
        "a full disk without the way on",
        "floquet/study/running.py",
        ", and --resume goes on from it",
        "",
        f"{STUDY} -k full_disk_in_a_worker",
    ),
    Mutant("the port of another cluster", "floquet/cluster.py", "127.0.0.1:0", ":8787", f"{DASK} -k command_line"),
    Mutant(
        "limits of the first designs alone",
        "floquet/study/shards.py",
        "        made = list(made)\n",
        "        made = list(made)[:1]\n",
        f"{STUDY} -k together",
    ),
    Mutant(
        "rows lost by extending",
        "floquet/study/extending.py",
        "    if lost:\n",
        "    if False:\n",
        "tests/test_extend.py -k not_every_row",
    ),
    Mutant(
        "databases exported over",
        "floquet/export.py",
        "return bool(file.tables)",
        "return False",
        f"{STUDY} -k exported_over",
    ),
    Mutant("files without a table verified", CHECKING, "if not file.tables:", "if False:", f"{STUDY} -k exported_over"),
    Mutant(
        "damaged parts passed over",
        "floquet/study/running.py",
        "    if damaged:\n",
        "    if False:\n",
        f"{STUDY} -k makes_damaged",
    ),
    Mutant(
        "ranges as they are calculated", "floquet/studyfile.py", "{x:.15g}", "{x:.17g}", f"{STUDY} -k one_would_write"
    ),
    Mutant(
        "parts left for good",
        "floquet/study/running.py",
        "        _clear(folder, study)\n",
        "",
        f"{STUDY} -k killed_run_left",
    ),
    Mutant(
        "parts of others removed",
        "floquet/study/running.py",
        'journal_of(folder).get("study_id") == study.id',
        "True",
        f"{STUDY} -k killed_run_left",
    ),
    Mutant(
        "half a merge left",
        "floquet/study/merging.py",
        "store.remove_leftovers(Path(out).parent, Path(out).name)",
        "pass",
        f"{PROOFS} -k merge",
    ),
    Mutant(
        "shards written in place",
        "floquet/store/files.py",
        'temporary = path.with_name(f".{path.name}.{secrets.token_hex(8)}.tmp")',
        "temporary = path",
        f"{PROOFS} -k resume",
    ),
    Mutant(
        "links replaced",
        "floquet/store/files.py",
        "path = _behind(Path(path))",
        "path = Path(path)",
        f"{STUDY} -k points_to",
    ),
    Mutant(
        "halves behind links left",
        "floquet/store/files.py",
        "(place := _behind(folder / name))",
        "(place := folder / name)",
        f"{STUDY} -k points_to",
    ),
    Mutant(
        "packed during a run",
        "floquet/study/packing.py",
        "if os.access(folder, os.W_OK)",
        "if False",
        f"{STUDY} -k nobody_packs",
    ),
    Mutant("a failing folder passed over", "floquet/store/files.py", "errno.EIO, errno.ENOSPC, errno.EDQUOT", "", KEPT),
    Mutant(
        "made again beside another run",
        "floquet/study/running.py",
        "if out.exists() and not extend:",
        "if False:",
        f"{STUDY} -k meanwhile",
    ),
    Mutant(
        "two runs at once",
        "floquet/study/folder.py",
        "        lock.acquire()\n",
        "        pass\n",
        f"{STUDY} -k two_runs",
    ),
    Mutant(
        "unfinished is not there",
        READING,
        '    if Path(f"{path}.parts").is_dir()',
        "    if False",
        f"{STUDY} -k not_finished",
    ),
    Mutant("a failing disk unknown", "floquet/store/files.py", "errno.EIO: ", "-1: ", f"{PROOFS} -k pack"),
    Mutant("lost shards forgotten", SHARED, "lost.append(futures[future])", "pass", f"{DASK} -k five_killed"),
    Mutant(
        "deadly shards arrived",
        SHARED,
        "_ended_there if died else",
        "(lambda: shard.file) if died else",
        f"{DASK} -k deadly",
    ),
    Mutant("any engine will do", SHARED, "if engine != ENGINE:", "if False:", f"{DASK} -k another_engine"),
    Mutant(
        "shards that nobody sees",
        SHARED,
        "if not appears(parts.folder / name):",
        "if False:",
        f"{DASK} -k see_the_folder",
    ),
    Mutant("remains of a seal passed over", READING, "seal.remains or ", "", f"{SEALED} -k left_of_a_seal"),
    Mutant("metadata unchecked", READING, "    if broken:\n", "    if False:\n", f"{SEALED} -k any_changed"),
    Mutant(
        "seal of the extents alone",
        SEAL,
        "total.update(file.read(min(PIECE, length - start)))",
        "pass",
        f"{SEALED} -k any_changed",
    ),
    Mutant(
        "chunks that are not there sealed",
        SEAL,
        "np.append(0, taken.sum(axis=1))",
        "np.append(0, taken[:, 0])",
        f"{SEALED} -k covers_all",
    ),
    Mutant(
        "extents unchecked", SEAL, "if not _in_order(extents, self.end):", "if False:", f"{SEALED} -k point_anywhere"
    ),
    Mutant(
        "sums of extents overflow",
        SEAL,
        "if np.any(first > end) or np.any(length > end):",
        "if False:",
        f"{SEALED} -k point_anywhere",
    ),
    Mutant(
        "files without a seal unexamined",
        READING,
        "if not seal.present and not examined:",
        "if False:",
        f"{SEALED} -k words_were",
    ),
    Mutant(
        "words unexamined",
        READING,
        "        if not self._described():\n            raise",
        "        if False:\n            raise",
        f"{SEALED} -k words_were",
    ),
    Mutant("variables from elsewhere", READING, "!= self._name or", "== b'' or", f"{SEALED} -k stored_elsewhere"),
    Mutant(
        "numbers of rows unchecked",
        READING,
        "yield from self._misnumbered(table, beat)",
        "pass",
        f"{SEALED} -k numbered_wrongly",
    ),
    Mutant(
        "a child is waited for without end", GUARD, "lines.get(timeout=patience)", "lines.get()", f"{SEALED} -k befalls"
    ),
    Mutant(
        "a dead child found nothing",
        GUARD,
        "    if found is None:\n        raise DamageError",
        "    if found is None:\n        return None\n        raise DamageError",
        f"{SEALED} -k befalls",
    ),
    Mutant("a child takes all memory", GUARD, "    limit_memory()\n    try:", "    try:", f"{SEALED} -k befalls"),
    Mutant("modules of the working folder", GUARD, '"-P", "-m"', '"-m"', f"{SEALED} -k no_module"),
    Mutant("impossible values", SCHEMA, '"a value that is not possible"', '""', f"{SEALED} -k not_possible"),
    Mutant(
        "rows not compared", CHECKING, "again[name].tobytes() == value.tobytes()", "True", f"{SEALED} -k never_computed"
    ),
    Mutant("another engine is equal", CHECKING, "<= bound) for name", "<= 1.0) for name", f"{SEALED} -k held_against"),
    Mutant(
        "the same engine within bounds", CHECKING, "(mapped or engine != ENGINE) and", "", f"{SEALED} -k never_computed"
    ),
    Mutant(
        "columns of a later release lost unsaid",
        "floquet/study/merging.py",
        "lost += sorted(",
        "sorted(",
        f"{SEALED} -k newer_minor",
    ),
    Mutant(
        "studies of any size",
        "floquet/studyfile.py",
        "designs * ratios > MOST_POINTS",
        "False",
        f"{SEALED} -k no_machine",
    ),
    Mutant(
        "grids of any size",
        "floquet/studyfile.py",
        "if designs > MOST_DESIGNS:",
        "if False:",
        f"{SEALED} -k no_machine",
    ),
    Mutant(
        "keys of any depth",
        "floquet/tomlfile.py",
        "if dots > MOST_DOTS:",
        "if False:",
        "tests/test_tomlfile.py -k keys_without",
    ),
    Mutant(
        "columns of any kind",
        "floquet/query/database.py",
        "if not isinstance(columns, Iterable):",
        "if False:",
        f"{ASKED} -k wrong_option",
    ),
)
