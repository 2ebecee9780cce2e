"""One panel of y'' = p(x) y from -1 to 1 by its Taylor series about 0, to order 24.

Written by generate.py, which explains it; do not edit.
"""

from __future__ import annotations

from typing import Any

__all__ = ["ORDER", "panel", "two_harmonics", "weights"]

ORDER = 24


def weights(table: Any) -> tuple[Any, ...]:
    """The rows of :func:`two_harmonics`' table (ORDER - 1, 2) as a tuple of numbers."""
    return (table[0, 0], table[0, 1], table[1, 0], table[1, 1], table[2, 0], table[2, 1], table[3, 0], table[3, 1], table[4, 0], table[4, 1], table[5, 0], table[5, 1], table[6, 0], table[6, 1], table[7, 0], table[7, 1], table[8, 0], table[8, 1], table[9, 0], table[9, 1], table[10, 0], table[10, 1], table[11, 0], table[11, 1], table[12, 0], table[12, 1], table[13, 0], table[13, 1], table[14, 0], table[14, 1], table[15, 0], table[15, 1], table[16, 0], table[16, 1], table[17, 0], table[17, 1], table[18, 0], table[18, 1], table[19, 0], table[19, 1], table[20, 0], table[20, 1], table[21, 0], table[21, 1], table[22, 0], table[22, 1])  # fmt: skip


def two_harmonics(q0: Any, even_1: Any, odd_1: Any, even_2: Any, odd_2: Any, w: tuple[Any, ...]) -> tuple[Any, ...]:
    """The coefficients of p for a mean and two harmonics about the centre of the panel, and their weights."""
    return (  # fmt: skip
        q0 * w[0] + even_1 * w[0] + even_2 * w[1],
        odd_1 * w[2] + odd_2 * w[3],
        even_1 * w[4] + even_2 * w[5],
        odd_1 * w[6] + odd_2 * w[7],
        even_1 * w[8] + even_2 * w[9],
        odd_1 * w[10] + odd_2 * w[11],
        even_1 * w[12] + even_2 * w[13],
        odd_1 * w[14] + odd_2 * w[15],
        even_1 * w[16] + even_2 * w[17],
        odd_1 * w[18] + odd_2 * w[19],
        even_1 * w[20] + even_2 * w[21],
        odd_1 * w[22] + odd_2 * w[23],
        even_1 * w[24] + even_2 * w[25],
        odd_1 * w[26] + odd_2 * w[27],
        even_1 * w[28] + even_2 * w[29],
        odd_1 * w[30] + odd_2 * w[31],
        even_1 * w[32] + even_2 * w[33],
        odd_1 * w[34] + odd_2 * w[35],
        even_1 * w[36] + even_2 * w[37],
        odd_1 * w[38] + odd_2 * w[39],
        even_1 * w[40] + even_2 * w[41],
        odd_1 * w[42] + odd_2 * w[43],
        even_1 * w[44] + even_2 * w[45],
    )


def panel(p0: Any, p1: Any, p2: Any, p3: Any, p4: Any, p5: Any, p6: Any, p7: Any, p8: Any, p9: Any, p10: Any, p11: Any, p12: Any, p13: Any, p14: Any, p15: Any, p16: Any, p17: Any, p18: Any, p19: Any, p20: Any, p21: Any, p22: Any) -> tuple[Any, Any, Any, Any, Any]:  # fmt: skip
    """F = Y(1) Y(-1)⁻¹ by rows, and a bound of the sum of the changes of its entries without the last two orders.

    The arguments are the Taylor coefficients of p, numbers or arrays (one entry a point).
    """
    u2 = (p0) * 0.5
    u3 = (p1) * 0.16666666666666666
    v3 = (p0) * 0.16666666666666666
    u4 = (p2 + p0 * u2) * 0.08333333333333333
    v4 = (p1) * 0.08333333333333333
    u5 = (p3 + p1 * u2 + p0 * u3) * 0.05
    v5 = (p2 + p0 * v3) * 0.05
    u6 = (p4 + p2 * u2 + p1 * u3 + p0 * u4) * 0.03333333333333333
    v6 = (p3 + p1 * v3 + p0 * v4) * 0.03333333333333333
    u7 = (p5 + p3 * u2 + p2 * u3 + p1 * u4 + p0 * u5) * 0.023809523809523808
    v7 = (p4 + p2 * v3 + p1 * v4 + p0 * v5) * 0.023809523809523808
    u8 = (p6 + p4 * u2 + p3 * u3 + p2 * u4 + p1 * u5 + p0 * u6) * 0.017857142857142856
    v8 = (p5 + p3 * v3 + p2 * v4 + p1 * v5 + p0 * v6) * 0.017857142857142856
    u9 = (p7 + p5 * u2 + p4 * u3 + p3 * u4 + p2 * u5 + p1 * u6 + p0 * u7) * 0.013888888888888888
    v9 = (p6 + p4 * v3 + p3 * v4 + p2 * v5 + p1 * v6 + p0 * v7) * 0.013888888888888888
    u10 = (p8 + p6 * u2 + p5 * u3 + p4 * u4 + p3 * u5 + p2 * u6 + p1 * u7 + p0 * u8) * 0.011111111111111112
    v10 = (p7 + p5 * v3 + p4 * v4 + p3 * v5 + p2 * v6 + p1 * v7 + p0 * v8) * 0.011111111111111112
    u11 = (p9 + p7 * u2 + p6 * u3 + p5 * u4 + p4 * u5 + p3 * u6 + p2 * u7 + p1 * u8 + p0 * u9) * 0.00909090909090909
    v11 = (p8 + p6 * v3 + p5 * v4 + p4 * v5 + p3 * v6 + p2 * v7 + p1 * v8 + p0 * v9) * 0.00909090909090909
    u12 = (p10 + p8 * u2 + p7 * u3 + p6 * u4 + p5 * u5 + p4 * u6 + p3 * u7 + p2 * u8 + p1 * u9 + p0 * u10) * 0.007575757575757576
    v12 = (p9 + p7 * v3 + p6 * v4 + p5 * v5 + p4 * v6 + p3 * v7 + p2 * v8 + p1 * v9 + p0 * v10) * 0.007575757575757576
    u13 = (p11 + p9 * u2 + p8 * u3 + p7 * u4 + p6 * u5 + p5 * u6 + p4 * u7 + p3 * u8 + p2 * u9 + p1 * u10 + p0 * u11) * 0.00641025641025641
    v13 = (p10 + p8 * v3 + p7 * v4 + p6 * v5 + p5 * v6 + p4 * v7 + p3 * v8 + p2 * v9 + p1 * v10 + p0 * v11) * 0.00641025641025641
    u14 = (p12 + p10 * u2 + p9 * u3 + p8 * u4 + p7 * u5 + p6 * u6 + p5 * u7 + p4 * u8 + p3 * u9 + p2 * u10 + p1 * u11 + p0 * u12) * 0.005494505494505495
    v14 = (p11 + p9 * v3 + p8 * v4 + p7 * v5 + p6 * v6 + p5 * v7 + p4 * v8 + p3 * v9 + p2 * v10 + p1 * v11 + p0 * v12) * 0.005494505494505495
    u15 = (p13 + p11 * u2 + p10 * u3 + p9 * u4 + p8 * u5 + p7 * u6 + p6 * u7 + p5 * u8 + p4 * u9 + p3 * u10 + p2 * u11 + p1 * u12 + p0 * u13) * 0.004761904761904762
    v15 = (p12 + p10 * v3 + p9 * v4 + p8 * v5 + p7 * v6 + p6 * v7 + p5 * v8 + p4 * v9 + p3 * v10 + p2 * v11 + p1 * v12 + p0 * v13) * 0.004761904761904762
    u16 = (p14 + p12 * u2 + p11 * u3 + p10 * u4 + p9 * u5 + p8 * u6 + p7 * u7 + p6 * u8 + p5 * u9 + p4 * u10 + p3 * u11 + p2 * u12 + p1 * u13 + p0 * u14) * 0.004166666666666667
    v16 = (p13 + p11 * v3 + p10 * v4 + p9 * v5 + p8 * v6 + p7 * v7 + p6 * v8 + p5 * v9 + p4 * v10 + p3 * v11 + p2 * v12 + p1 * v13 + p0 * v14) * 0.004166666666666667
    u17 = (p15 + p13 * u2 + p12 * u3 + p11 * u4 + p10 * u5 + p9 * u6 + p8 * u7 + p7 * u8 + p6 * u9 + p5 * u10 + p4 * u11 + p3 * u12 + p2 * u13 + p1 * u14 + p0 * u15) * 0.003676470588235294
    v17 = (p14 + p12 * v3 + p11 * v4 + p10 * v5 + p9 * v6 + p8 * v7 + p7 * v8 + p6 * v9 + p5 * v10 + p4 * v11 + p3 * v12 + p2 * v13 + p1 * v14 + p0 * v15) * 0.003676470588235294
    u18 = (p16 + p14 * u2 + p13 * u3 + p12 * u4 + p11 * u5 + p10 * u6 + p9 * u7 + p8 * u8 + p7 * u9 + p6 * u10 + p5 * u11 + p4 * u12 + p3 * u13 + p2 * u14 + p1 * u15 + p0 * u16) * 0.0032679738562091504
    v18 = (p15 + p13 * v3 + p12 * v4 + p11 * v5 + p10 * v6 + p9 * v7 + p8 * v8 + p7 * v9 + p6 * v10 + p5 * v11 + p4 * v12 + p3 * v13 + p2 * v14 + p1 * v15 + p0 * v16) * 0.0032679738562091504
    u19 = (p17 + p15 * u2 + p14 * u3 + p13 * u4 + p12 * u5 + p11 * u6 + p10 * u7 + p9 * u8 + p8 * u9 + p7 * u10 + p6 * u11 + p5 * u12 + p4 * u13 + p3 * u14 + p2 * u15 + p1 * u16 + p0 * u17) * 0.0029239766081871343
    v19 = (p16 + p14 * v3 + p13 * v4 + p12 * v5 + p11 * v6 + p10 * v7 + p9 * v8 + p8 * v9 + p7 * v10 + p6 * v11 + p5 * v12 + p4 * v13 + p3 * v14 + p2 * v15 + p1 * v16 + p0 * v17) * 0.0029239766081871343
    u20 = (p18 + p16 * u2 + p15 * u3 + p14 * u4 + p13 * u5 + p12 * u6 + p11 * u7 + p10 * u8 + p9 * u9 + p8 * u10 + p7 * u11 + p6 * u12 + p5 * u13 + p4 * u14 + p3 * u15 + p2 * u16 + p1 * u17 + p0 * u18) * 0.002631578947368421
    v20 = (p17 + p15 * v3 + p14 * v4 + p13 * v5 + p12 * v6 + p11 * v7 + p10 * v8 + p9 * v9 + p8 * v10 + p7 * v11 + p6 * v12 + p5 * v13 + p4 * v14 + p3 * v15 + p2 * v16 + p1 * v17 + p0 * v18) * 0.002631578947368421
    u21 = (p19 + p17 * u2 + p16 * u3 + p15 * u4 + p14 * u5 + p13 * u6 + p12 * u7 + p11 * u8 + p10 * u9 + p9 * u10 + p8 * u11 + p7 * u12 + p6 * u13 + p5 * u14 + p4 * u15 + p3 * u16 + p2 * u17 + p1 * u18 + p0 * u19) * 0.002380952380952381
    v21 = (p18 + p16 * v3 + p15 * v4 + p14 * v5 + p13 * v6 + p12 * v7 + p11 * v8 + p10 * v9 + p9 * v10 + p8 * v11 + p7 * v12 + p6 * v13 + p5 * v14 + p4 * v15 + p3 * v16 + p2 * v17 + p1 * v18 + p0 * v19) * 0.002380952380952381
    u22 = (p20 + p18 * u2 + p17 * u3 + p16 * u4 + p15 * u5 + p14 * u6 + p13 * u7 + p12 * u8 + p11 * u9 + p10 * u10 + p9 * u11 + p8 * u12 + p7 * u13 + p6 * u14 + p5 * u15 + p4 * u16 + p3 * u17 + p2 * u18 + p1 * u19 + p0 * u20) * 0.0021645021645021645
    v22 = (p19 + p17 * v3 + p16 * v4 + p15 * v5 + p14 * v6 + p13 * v7 + p12 * v8 + p11 * v9 + p10 * v10 + p9 * v11 + p8 * v12 + p7 * v13 + p6 * v14 + p5 * v15 + p4 * v16 + p3 * v17 + p2 * v18 + p1 * v19 + p0 * v20) * 0.0021645021645021645
    u23 = (p21 + p19 * u2 + p18 * u3 + p17 * u4 + p16 * u5 + p15 * u6 + p14 * u7 + p13 * u8 + p12 * u9 + p11 * u10 + p10 * u11 + p9 * u12 + p8 * u13 + p7 * u14 + p6 * u15 + p5 * u16 + p4 * u17 + p3 * u18 + p2 * u19 + p1 * u20 + p0 * u21) * 0.001976284584980237
    v23 = (p20 + p18 * v3 + p17 * v4 + p16 * v5 + p15 * v6 + p14 * v7 + p13 * v8 + p12 * v9 + p11 * v10 + p10 * v11 + p9 * v12 + p8 * v13 + p7 * v14 + p6 * v15 + p5 * v16 + p4 * v17 + p3 * v18 + p2 * v19 + p1 * v20 + p0 * v21) * 0.001976284584980237
    u24 = (p22 + p20 * u2 + p19 * u3 + p18 * u4 + p17 * u5 + p16 * u6 + p15 * u7 + p14 * u8 + p13 * u9 + p12 * u10 + p11 * u11 + p10 * u12 + p9 * u13 + p8 * u14 + p7 * u15 + p6 * u16 + p5 * u17 + p4 * u18 + p3 * u19 + p2 * u20 + p1 * u21 + p0 * u22) * 0.0018115942028985507
    v24 = (p21 + p19 * v3 + p18 * v4 + p17 * v5 + p16 * v6 + p15 * v7 + p14 * v8 + p13 * v9 + p12 * v10 + p11 * v11 + p10 * v12 + p9 * v13 + p8 * v14 + p7 * v15 + p6 * v16 + p5 * v17 + p4 * v18 + p3 * v19 + p2 * v20 + p1 * v21 + p0 * v22) * 0.0018115942028985507
    ue = u24 + u22 + u20 + u18 + u16 + u14 + u12 + u10 + u8 + u6 + u4 + u2 + 1.0
    ur = 24.0 * u24 + 22.0 * u22 + 20.0 * u20 + 18.0 * u18 + 16.0 * u16 + 14.0 * u14 + 12.0 * u12 + 10.0 * u10 + 8.0 * u8 + 6.0 * u6 + 4.0 * u4 + 2.0 * u2
    uo = u23 + u21 + u19 + u17 + u15 + u13 + u11 + u9 + u7 + u5 + u3
    us = 23.0 * u23 + 21.0 * u21 + 19.0 * u19 + 17.0 * u17 + 15.0 * u15 + 13.0 * u13 + 11.0 * u11 + 9.0 * u9 + 7.0 * u7 + 5.0 * u5 + 3.0 * u3
    ve = v24 + v22 + v20 + v18 + v16 + v14 + v12 + v10 + v8 + v6 + v4
    vr = 24.0 * v24 + 22.0 * v22 + 20.0 * v20 + 18.0 * v18 + 16.0 * v16 + 14.0 * v14 + 12.0 * v12 + 10.0 * v10 + 8.0 * v8 + 6.0 * v6 + 4.0 * v4
    vo = v23 + v21 + v19 + v17 + v15 + v13 + v11 + v9 + v7 + v5 + v3 + 1.0
    vs = 23.0 * v23 + 21.0 * v21 + 19.0 * v19 + 17.0 * v17 + 15.0 * v15 + 13.0 * v13 + 11.0 * v11 + 9.0 * v9 + 7.0 * v7 + 5.0 * v5 + 3.0 * v3 + 1.0
    up, um, udp, udm = ue + uo, ue - uo, us + ur, us - ur
    vp, vm, vdp, vdm = ve + vo, ve - vo, vs + vr, vs - vr
    f0 = up * vdm - vp * udm
    f1 = vp * um - up * vm
    f2 = udp * vdm - vdp * udm
    f3 = vdp * um - udp * vm
    e = (23.0 * (abs(u23) + abs(v23)) + 24.0 * (abs(u24) + abs(v24))) * (abs(up) + abs(um) + abs(udp) + abs(udm) + abs(vp) + abs(vm) + abs(vdp) + abs(vdm))
    return f0, f1, f2, f3, e
