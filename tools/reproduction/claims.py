# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Every quantitative claim of the dissertation that figures of this reproduction bear on; App. A
and B here.
"""

from reproduction.claim import Claim
from reproduction.claims_cde import APPENDIX_C, APPENDIX_D, APPENDIX_E
from reproduction.read_numbers import channel, number, ratio

CUT_OFF = "cut-off read as the filter's pole in rad/s; one frame late, forward Euler, ZOH"
REAL = "real devices add friction, quantisation and limits that the model lacks"
LAG = "holds and filter delay once around amount to 2 T_VE with Butterworth 25/50 Hz"
PARSEVAL = "the proof bounds the final energy, not the path; chirp amplitude is not given"
COINCIDENCE = "a coincidence: the lag of this filter and hold happens to be 2 T_VE"
MEASURED = f"{REAL}; {CUT_OFF}"


APPENDIX_A = (
    Claim(
        "A 4.1, Eq. 18",
        "aliasing with M = 2 releases T α² (2 Ω_max - π)/π (summed over its closed form, "
        "Ω_max = 2.4)",
        "none: a sum over the wave itself",
        ratio(
            number("A8", "counterexample_left_shift_0"), number("A8", "counterexample_printed")
        ),
        printed=1.0,
    ),
    Claim(
        "A 3",
        "aliasing may also keep energy (share of what went in, the same wave one tick later)",
        "which of the values is sent decides the sign",
        number("A8", "counterexample_left_shift_1"),
        at_least=0.0,
    ),
    Claim("A 3, Eq. 13", "without aliasing the balance is zero (last over the energy of the wave)",
          "a wave whose spectrum ends at π/M, M = 20", number("A8", "band_limited_last"),
          printed=0.0),
    Claim("A 3, Eq. 9 and 13", "without aliasing the rate drop is passive at all t (lowest "
          "balance at the end of a frame over the energy of the wave)",
          "Parseval's theorem bounds the final balance, not the path",
          number("A8", "band_limited_lowest"), at_least=-1e-6),
    Claim("A 4.2, Eq. 21", "the slave side reflects with gain 1 for any K and T_VE (largest "
          "distance from 1)", "trapezoid, loop solved, without damping: all-pass",
          number("A8", "reflection_server"), printed=0.0, within=1e-6),
    Claim("A 4.2, Eq. 21", "a similar argument holds for the master side (largest gain)",
          "a held device without damping: (2m/T + b)/(2m/T - b) at half the tick rate, "
          "b = 25 Ns/m, m = 0.15 kg",
          number("A8", "reflection_device"), at_most=1.0),
    Claim("A 4.2, Fig. 3", "the allowed cut-off falls with M (K = 2000 N/m, M = 10 over 2)",
          "one step of computational delay, trapezoid; with the loop solved no limit "
          "from M = 3 on",
          ratio(number("A3", "one_step_delay_k_2000_m_10"),
                number("A3", "one_step_delay_k_2000_m_2")), at_most=1.0,
          only="under a condition that the text excludes: with the computational delay"),
    Claim("A 4.2, Fig. 3", "half the update rate is the more restrictive bound "
          "(points of the curves below it)",
          "-20 dB of a first-order filter; the computational delay is active, too: "
          "stiff walls at large M",
          number("A3", "one_step_delay_points_below_the_passive_bound"), at_most=0.0),
    Claim("A 5, Eq. 24", "the channel is a spring of b/T_VE (b = 25 Ns/m)",
          LAG,
          channel("A4", 25, 3500.0), printed=1250.0, unit="N/m", only=COINCIDENCE),
    Claim("A 5, Eq. 24", "the channel is a spring of b/T_VE (b = 80 Ns/m)",
          LAG, channel("A4", 80, 3500.0), printed=4000.0, unit="N/m", only=COINCIDENCE),
    Claim("A 5, Eq. 24", "the channel is a spring of b/T_VE (b = 25 Ns/m, another filter)",
          "Butterworth 50/100 Hz: the channel is a spring of 2b/τ, τ the lag once around",
          channel("A4", 25, 3500.0, prefix="other_filter_"), printed=1250.0, unit="N/m"),
    Claim("A 5, Fig. 4(a)", "rendered stiffness grows with b (80 over 25 Ns/m)",
          "loop solved, trapezoid",
          ratio(number("A4", "k_felt_b_80"), number("A4", "k_felt_b_25")), at_least=1.0),
    Claim("A 5, Fig. 4(a)", "waves transmit less than the ideal coupling (share at b = 80 Ns/m)",
          "loop solved, trapezoid",
          ratio(number("A4", "k_felt_b_80"), number("A4", "k_felt_ideal")), at_most=1.0),
    Claim("A 5, Fig. 4(b)", "a larger b can increase the stiffness of short contacts (mean "
          "admittance from 5 to 50 Hz, b = 80 over 25 Ns/m)", "loop solved, trapezoid",
          number("A4", "high_b_80_over_25"), at_most=1.0),
    Claim("A 5, Fig. 4(b)", "a larger b can increase the stiffness of short contacts (share of "
          "the frequencies from 5 to 50 Hz at which b = 80 is stiffer than b = 25 Ns/m)",
          "loop solved, trapezoid; *can*: at some frequencies",
          number("A4", "high_share_b_80_stiffer"), at_least=0.01),
    Claim("A 6, Fig. 5", "contacts at least four times as stiff as with direct coupling",
          "largest over all damping, b = 80 Ns/m, m = 0.15 kg, b_hd = 1 Ns/m; neither is given",
          ratio(number("A5", "largest_waves_b_80"), number("A5", "largest_direct")),
          at_least=4.0),
    Claim("A 6, Fig. 6", "stable with the 25 Hz filter (spectral radius)",
          "one step of delay, backward Euler", number("A6", "spectral_radius"), at_most=1.0),
    Claim("A 6, Fig. 7", "unstable with the 250 Hz filter (spectral radius)",
          "one step of delay, backward Euler: aliasing together with the computational delay",
          number("A7", "spectral_radius"), at_least=1.0),
    Claim("A 6, Fig. 7", "aliasing alone makes it unstable (spectral radius, loop solved)",
          "with the loop solved the 250 Hz filter is stable",
          number("A7", "spectral_radius_loop_solved"), at_least=1.0),
    Claim("A 6, Fig. 8", "the 10 Hz filter keeps the balance at zero or above throughout",
          PARSEVAL,
          number("A8", "minimum_10_hz_j"), at_least=0.0, unit="J"),
    Claim("A 6, Fig. 8", "the 25 Hz filter keeps the balance at zero or above throughout",
          PARSEVAL, number("A8", "minimum_25_hz_j"), at_least=0.0, unit="J"),
    Claim("A 6, Fig. 8", "the 50 Hz filter may keep the final balance positive",
          PARSEVAL, number("A8", "final_50_hz_j"), at_least=0.0, unit="J"),
    Claim("A 6, Fig. 8", "the 250 Hz filter may keep the final balance positive",
          PARSEVAL, number("A8", "final_250_hz_j"), at_least=0.0, unit="J"),
)  # fmt: skip
STATICS = "trivially: a steady press is in equilibrium whatever the coupling and the delay"
K2 = "k_max_pole_50_delay_"
APPENDIX_B = (
    *(
        Claim("B 4, Fig. 2",
              f"delay hardly matters for the largest stiffness ({n} T_n over 1 T_n)", CUT_OFF,
              ratio(number("B2", K2 + str(n)), number("B2", K2 + "1")),
              printed=1.0, within=0.15)
        for n in (0, 2, 3)
    ),
    *(
        Claim("B 4, Fig. 2", f"stiffer with cut-off 50 than with 100 (T_d = {n} T_n)", CUT_OFF,
              ratio(number("B2", K2 + str(n)), number("B2", f"k_max_pole_100_delay_{n}")),
              at_least=1.0)
        for n in (0, 1, 2, 3)
    ),
    *(
        Claim("B 4, Fig. 3", f"stiffer with waves than with direct coupling (T_d = {n} T_n)",
              CUT_OFF, ratio(number("B2", K2 + str(n)), number("B3", f"k_max_delay_{n}")),
              at_least=1.0)
        for n in (0, 1, 2)
    ),
    *(
        Claim("B 5", f"largest stiffness measured with waves, T_d = {n} T_n", MEASURED,
              number("B2", K2 + str(n)), printed=value, unit="N/m")
        for n, value in ((0, 1200.0), (1, 600.0), (2, 600.0), (3, 600.0))
    ),
    *(
        Claim("B 5", f"largest stiffness measured with direct coupling, T_d = {n} T_n", REAL,
              number("B3", f"k_max_delay_{n}"), printed=value, unit="N/m")
        for n, value in ((0, 700.0), (1, 60.0), (2, 0.0))
    ),
    *(
        Claim("B 5", f"stiffness with waves over direct coupling, measured, T_d = {n} T_n",
              MEASURED, ratio(number("B2", K2 + str(n)), number("B3", f"k_max_delay_{n}")),
              printed=value)
        for n, value in ((0, 1200.0 / 700.0), (1, 10.0))
    ),
    *(
        Claim("B 5, Fig. 5", f"forces settle at the 1 N applied, T_d = {8 * n} ms",
              "delayed first-order hold, one frame late", number("B5", f"force_delay_{n}_n"),
              printed=1.0, unit="N", only=STATICS)
        for n in (0, 2, 3)
    ),
    *(
        Claim("B 5, Fig. 5", f"the avatar presses 1 N/K into the cube, T_d = {8 * n} ms",
              "delayed first-order hold, one frame late", number("B5", f"pressed_delay_{n}_mm"),
              printed=2.0, unit="mm", only=STATICS)
        for n in (0, 2, 3)
    ),
    Claim("B App. B, Eq. 43 to 54", "the delayed first-order hold is passive (lowest balance at "
          "the end of a frame over what went in)", "200 random waves of 50 packets, M = 8",
          number("B5", "hold_lowest_balance"), at_least=0.0),
    Claim("B 4, Fig. 2", "the cut-off of the filter is 50 Hz (largest stiffness, T_d = T_n)",
          "read as -3 dB at 50 Hz nothing is stable; the figures fit a pole of "
          "50 rad/s, 8 Hz", number("B2", "k_max_cutoff_50_hz_3_db_delay_1"), at_least=100.0,
          unit="N/m"),
    Claim("B 4, Fig. 2", "the cut-off of the filter is 50 Hz (largest stiffness over that of the "
          "figure, T_d = T_n)", "read as -20 dB at 50 Hz, a pole of 31.6 rad/s",
          ratio(number("B2", "k_max_stop_50_hz_20_db_delay_1"), number("B2", K2 + "1")),
          printed=1.0),
)  # fmt: skip
CLAIMS = (*APPENDIX_A, *APPENDIX_B, *APPENDIX_C, *APPENDIX_D, *APPENDIX_E)
