# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Every quantitative claim of the dissertation that figures of this reproduction bear on."""

from collections.abc import Callable

from pmwvc_analysis.reproduction.claim import Claim, Numbers

Read = Callable[[Numbers], float | None]
CUT_OFF = "cut-off read as the filter's pole in rad/s; one frame late, forward Euler, ZOH"
REAL = "real devices add friction, quantisation and limits that the model lacks"
MEASURED = f"{REAL}; {CUT_OFF}"


def number(figure: str, name: str) -> Read:
    """Return a reader of one number."""

    def read(numbers: Numbers) -> float | None:
        value: float | None = numbers[figure][name]
        return value

    return read


def ratio(above: Read, below: Read) -> Read:
    """Return a reader of a quotient; None where there is none."""

    def read(numbers: Numbers) -> float | None:
        top, bottom = above(numbers), below(numbers)
        return None if top is None or not bottom else top / bottom

    return read


def channel(figure: str, impedance: int, contact: float) -> Read:
    """Return a reader of the channel's stiffness, in series with the contact's."""

    def read(numbers: Numbers) -> float | None:
        felt: float = numbers[figure][f"k_felt_b_{impedance}"]
        return 1.0 / (1.0 / felt - 1.0 / contact)

    return read


APPENDIX_A = (
    Claim(
        "A 4.1, Eq. 18",
        "aliasing with M = 2 gives out T α² (2 Ω_max - π)/π (summed over its closed form, "
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
    Claim("A 4.2, Fig. 3", "the allowed cut-off falls with M (K = 2000 N/m, M = 10 over 2)",
          "one step of computational delay, trapezoid; with the loop solved there is no limit "
          "from M = 3 on, so the text's \"in the absence of computational delay\" does not give "
          "this figure",
          ratio(number("A3", "one_step_delay_k_2000_m_10"),
                number("A3", "one_step_delay_k_2000_m_2")), at_most=1.0),
    Claim("A 4.2, Fig. 3", "half the update rate is the more restrictive bound "
          "(points of the curves below it)",
          "-20 dB of a first-order filter; the computational delay is active, too: "
          "stiff walls at large M",
          number("A3", "one_step_delay_points_below_the_passive_bound"), at_most=0.0),
    Claim("A 5, Eq. 24", "the channel is a spring of b/T_VE (b = 25 Ns/m)",
          "holds and filter delay once around amount to 2 T_VE with Butterworth 25/50 Hz",
          channel("A4", 25, 3500.0), printed=1250.0, unit="N/m"),
    Claim("A 5, Eq. 24", "the channel is a spring of b/T_VE (b = 80 Ns/m)",
          "as above", channel("A4", 80, 3500.0), printed=4000.0, unit="N/m"),
    Claim("A 5, Fig. 4(a)", "felt stiffness grows with b (80 over 25 Ns/m)",
          "loop solved, trapezoid",
          ratio(number("A4", "k_felt_b_80"), number("A4", "k_felt_b_25")), at_least=1.0),
    Claim("A 5, Fig. 4(a)", "waves transmit less than the ideal coupling (share at b = 80 Ns/m)",
          "loop solved, trapezoid",
          ratio(number("A4", "k_felt_b_80"), number("A4", "k_felt_ideal")), at_most=1.0),
    Claim("A 6, Fig. 5", "contacts at least four times as stiff as with direct coupling",
          "largest over all damping, b = 80 Ns/m, m = 0.15 kg, b_hd = 1 Ns/m: neither b nor the "
          "device are given for this figure",
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
          "the proof bounds the energy at the end, not on the way; chirp amplitude is not given",
          number("A8", "minimum_10_hz_j"), at_least=0.0, unit="J"),
    Claim("A 6, Fig. 8", "the 25 Hz filter keeps the balance at zero or above throughout",
          "as above", number("A8", "minimum_25_hz_j"), at_least=0.0, unit="J"),
    Claim("A 6, Fig. 8", "the 50 Hz filter may keep the final balance positive",
          "as above", number("A8", "final_50_hz_j"), at_least=0.0, unit="J"),
    Claim("A 6, Fig. 8", "the 250 Hz filter may keep the final balance positive",
          "as above", number("A8", "final_250_hz_j"), at_least=0.0, unit="J"),
)  # fmt: skip
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
              printed=1.0, unit="N")
        for n in (0, 2, 3)
    ),
    *(
        Claim("B 5, Fig. 5", f"the avatar presses 1 N/K into the cube, T_d = {8 * n} ms",
              "delayed first-order hold, one frame late", number("B5", f"pressed_delay_{n}_mm"),
              printed=2.0, unit="mm")
        for n in (0, 2, 3)
    ),
)  # fmt: skip
APPENDIX_C = (
    Claim("C 3, Fig. 3", "one step of delay leaves a much smaller region (area over that without)",
          "printed polynomials, which do not follow from one diagram",
          ratio(number("C3", "area_printed_sigma_0_one_step_delay"),
                number("C3", "area_printed_sigma_0_unwrapped")), at_most=0.5),
    Claim("C 3, Fig. 3", "the loop unwrapped has a region at sigma = 0 (area)",
          "consistent diagram: a sampled mass gives out energy, and nothing takes it",
          number("C3", "area_loop_sigma_0_unwrapped"), at_least=0.1),
    Claim("C 3, Fig. 3", "one step of delay leaves a smaller region, with damping sigma = 0.2",
          "consistent diagram", number("C3", "ratio_loop_sigma_0.2"), at_most=0.5),
    Claim("C 4, Eq. 14", "the computational delay always gives out energy (of a contact)",
          "the same: dE = -T/(2b) [sum (F(n) - F(n-1))^2 + F(N)^2]",
          number("C5", "made_by_delay_none_mj"), at_most=0.0, unit="mJ"),
    Claim("C 5, Eq. 15", "the algorithm restores passivity (lowest balance of the port)",
          "as printed: the sign gives energy out, the running sum does so again at every step",
          number("C5", "lowest_after_printed_mj"), at_least=0.0, unit="mJ"),
    Claim("C 5", "the algorithm restores passivity (lowest balance of the port)",
          "corrected: each step's own energy, what cannot be paid at once carried as a debt",
          number("C5", "lowest_after_corrected_mj"), at_least=0.0, unit="mJ"),
    Claim("C 6, Fig. 4", "compensation nearly doubles the stiffness (largest over all damping)",
          "corrected; at rest means at rest: a wave that is stretched each time the force changes "
          "keeps a light wall in motion", ratio(number("C4", "largest_corrected"),
          number("C4", "largest_waves")), printed=2.0),
    Claim("C 6, Fig. 4", "compensation nearly doubles the stiffness (B = 0 Ns/m)",
          "port ledger: it bounds what a wall can give out, and does nothing before that",
          ratio(number("C4", "at_0_ledger"), number("C4", "at_0_waves")), printed=2.0),
    Claim("C 6, Fig. 5(c)", "the balance falls below zero before compensation",
          "simulated hand; trapezoid: active by a hair, which this contact does not show",
          number("C5", "lowest_before_none_mj"), at_most=-1e-3, unit="mJ"),
    Claim("C 6, Fig. 5(c)", "after compensation it is almost that of the environment (distance)",
          "corrected", number("C5", "apart_from_environment_corrected"), printed=0.0),
    Claim("C 6, Fig. 5(b)", "forces agree in contact (device over environment)", "corrected",
          ratio(number("C5", "force_end_n"), number("C5", "contact_force_end_n")), printed=1.0),
)  # fmt: skip
EQUIVALENT = "equivalent form (Fig. 2), m = 0.5 kg, encoder of 60 um; neither is given"
APPENDIX_D = (
    Claim("D 2.1, Eq. 5", "the filter is a spring of 2 b λ (b = 25 Ns/m)",
          "λ = 51.3 rad/s; holds and packets add their lag to the filter's",
          channel("D3", 25, 2000.0), printed=2564.7, unit="N/m"),
    Claim("D 2.1, Fig. 3", "larger b, stiffer at low frequency (80 over 10 Ns/m)", "loop solved",
          ratio(number("D3", "k_felt_b_80"), number("D3", "k_felt_b_10")), at_least=1.0),
    Claim("D 2.1, Fig. 4", "larger b, lower first natural frequency (80 over 25 Ns/m)",
          "loop solved; device of App. A",
          ratio(number("D4", "first_peak_hz_b_80"), number("D4", "first_peak_hz_b_25")),
          at_most=1.0),
    Claim("D 4", "α of the minimax design", "flattest right-hand side of Eq. 14 on 512 points; "
          "the error function is not printed", number("D5", "alpha_ours"),
          printed=0.929134319755588, within=0.001),
    Claim("D 3, Eq. 14", "the designed filter meets the passivity condition",
          "environment reflects in phase", number("D5", "in_phase_largest_printed"),
          at_most=1.0),
    Claim("D 3, Eq. 14", "the condition is independent of the environment",
          "any passive environment: |H_LP| + |H_HP|/2",
          number("D5", "any_environment_largest_printed"), at_most=1.0),
    Claim("D 5, Fig. 7", "with the filter the first natural frequency is nearer to the ideal "
          "(with over without, b = 80 Ns/m)", "loop solved; filter with its loop solved",
          ratio(number("D7", "first_peak_hz_b_80"), number("D4", "first_peak_hz_b_80")),
          at_least=1.0),
    Claim("D 5, Fig. 6", "the filter leaves low frequencies alone (felt stiffness with over "
          "without, b = 80 Ns/m)", "loop solved; filter with its loop solved",
          ratio(number("D6", "k_felt_b_80"), number("D3", "k_felt_b_80")), printed=1.0),
    Claim("D 6, Fig. 8, 10", "the filter takes the noise from the force (power beyond 60 Hz, "
          "without over with)", EQUIVALENT,
          lambda found: (found["D8"]["force_noise_n"] / found["D10"]["force_noise_n"]) ** 2,
          at_least=1.0),
    Claim("D 6, Fig. 9", "the wrong filter makes the system unstable (spectral radius)",
          EQUIVALENT, number("D9", "spectral_radius"), at_least=1.0),
    Claim("D 6, Fig. 10", "the designed filter does not (spectral radius)",
          EQUIVALENT, number("D10", "spectral_radius"), at_most=1.0),
    Claim("D 6, Fig. 11, 12", "the first force peak is almost twice as large without filter",
          EQUIVALENT,
          ratio(number("D11", "force_largest_n"), number("D12", "force_largest_n")), printed=2.0),
)  # fmt: skip
APPENDIX_E = (
    *(
        Claim("E 3.1, Fig. 4", f"largest stiffness at B = 1 Ns/m ({words})",
              "one step of delay, m = 0.1 kg, b_hd = 1.5 Ns/m; no reading tried gives 800",
              number("E4", f"at_1_{name}"), printed=800.0, unit="N/m")
        for name, words in (("backward", "backward Euler"), ("trapezoid", "trapezoid"),
                            ("forward", "forward Euler"))
    ),
    Claim("E 2, Fig. 2(a)", "larger b, stiffer at low frequency (50 over 10 Ns/m)", "loop solved",
          ratio(number("E2", "k_felt_b_50"), number("E2", "k_felt_b_10")), at_least=1.0),
    Claim("E 2, Fig. 2(b)", "larger b, lower first natural frequency (50 over 10 Ns/m)",
          "loop solved", ratio(number("E2", "first_peak_hz_b_50"),
                               number("E2", "first_peak_hz_b_10")), at_most=1.0),
    Claim("E 3.1, Fig. 5", "the stiffness of the local model does not affect stability (largest "
          "K_VE, with over without)", "B_LM = 5 Ns/m, K_p = 0",
          ratio(number("E5", "least_gain_0"), number("E5", "plain")), printed=1.0),
    Claim("E 3.1, Fig. 5", "filter bank, local model and K_p = 20 improve stability (largest K_VE "
          "over that of waves alone)", "B_LM = 5 Ns/m",
          ratio(number("E5", "least_gain_20"), number("E5", "plain")), at_least=1.0),
    Claim("E 3.1", "stable with a local model of B_LM = 1 Ns/m (spectral radius)",
          "sampled spring and damper with its loop solved; stable from 3.0 Ns/m on",
          number("E5", "spectral_radius_damping_1"), at_most=1.0),
    Claim("E 3.2, Fig. 6(a)", "at rest K_p makes the environment's stiffness felt, whatever b",
          "K_p = 20, any HP", number("E6", "k_felt_table"), printed=500.0, unit="N/m"),
    Claim("E 3.2, Fig. 6(b)", "the first natural frequency approaches the ideal (with over "
          "without)", "HP of Table 1: nothing of the resonance passes it",
          ratio(number("E6", "first_peak_hz_table"), number("E6", "first_peak_hz_waves")),
          at_least=1.2),
    Claim("E 3.2, Fig. 6(b)", "the first natural frequency approaches the ideal (with over "
          "without)", "HP of first order, 4 Hz; the ideal is at 10.99 Hz",
          ratio(number("E6", "first_peak_hz_bank"), number("E6", "first_peak_hz_waves")),
          at_least=1.2),
    Claim("E 4, Fig. 7", "sweeps show the same as the analysis (first peak, measured over model)",
          "simulated sweep", ratio(number("E7", "first_peak_hz_bank"),
                                   number("E6", "first_peak_hz_bank")), printed=1.0),
    Claim("E 4, Fig. 8", "filter bank and local model transmit close to 500 N/m (at rest)",
          "K_p = 20", number("E8", "lowest_table"), printed=500.0, unit="N/m"),
    Claim("E 4, Fig. 8", "filter bank and local model transmit close to 500 N/m (mean to 10 Hz)",
          "HP of first order, 4 Hz", number("E8", "mean_to_10_hz_bank"), printed=500.0,
          unit="N/m"),
)  # fmt: skip
CLAIMS = (*APPENDIX_A, *APPENDIX_B, *APPENDIX_C, *APPENDIX_D, *APPENDIX_E)
