# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Claims of App. C, D and E."""

from reproduction.claim import Claim
from reproduction.read_numbers import channel, number, ratio

APPENDIX_C = (
    Claim("C 3, Fig. 3", "one step of delay leaves a much smaller region (area over that without)",
          "printed polynomials, which do not follow from one diagram",
          ratio(number("C3", "area_printed_sigma_0_one_step_delay"),
                number("C3", "area_printed_sigma_0_unwrapped")), at_most=0.5,
          only="from the window of the plot: unwrapped, the region has no upper end"),
    Claim("C 3, Fig. 3", "the loop unwrapped has a region with an end (area in a window four "
          "times as high over that in the window)", "printed polynomials",
          ratio(number("C3", "area_printed_sigma_0_unwrapped_window_four_times_as_high"),
                number("C3", "area_printed_sigma_0_unwrapped")), printed=1.0),
    Claim("C 3, Fig. 3", "the loop unwrapped has a region at sigma = 0 (area)",
          "consistent diagram: a sampled mass releases energy that nothing absorbs",
          number("C3", "area_loop_sigma_0_unwrapped"), at_least=0.1),
    Claim("C 3, Fig. 3", "one step of delay leaves a smaller region, with damping sigma = 0.2",
          "consistent diagram", number("C3", "ratio_loop_sigma_0.2"), at_most=0.5),
    Claim("C 4, Eq. 14", "the computational delay always releases energy (of a contact)",
          "the same: dE = -T/(2b) [sum (F(n) - F(n-1))^2 + F(N)^2]",
          number("C5", "made_by_delay_none_mj"), at_most=0.0, unit="mJ"),
    Claim("C 5, Eq. 15", "the algorithm restores passivity (lowest balance of the port)",
          "as printed: the sign releases energy, the running sum repeats it at every step",
          number("C5", "lowest_after_printed_mj"), at_least=0.0, unit="mJ"),
    Claim("C 5", "the algorithm restores passivity (lowest balance of the port)",
          "corrected: each step's own energy, what cannot be paid at once carried as a deficit",
          number("C5", "lowest_after_corrected_mj"), at_least=0.0, unit="mJ"),
    Claim("C 6, Fig. 4", "stiffer with waves than with direct coupling (B = 0 Ns/m)",
          "one step of delay, backward Euler, no compensation",
          ratio(number("C4", "at_0_waves"), number("C4", "at_0_direct")), at_least=1.0),
    Claim("C 6, Fig. 4", "stiffer with waves than with direct coupling (largest over all damping)",
          "one step of delay, backward Euler, no compensation",
          ratio(number("C4", "largest_waves"), number("C4", "largest_direct")), at_least=1.0),
    Claim("C 6, Fig. 4", "compensation nearly doubles the stiffness (B = 0 Ns/m)",
          "corrected; trapezoid, 0.1 N of friction and an encoder of 55 um, as real devices have",
          number("C5", "factor_at_0"), at_least=1.5),
    Claim("C 6, Fig. 4", "compensation nearly doubles the stiffness (B = 5 Ns/m)",
          "corrected; trapezoid, 0.1 N of friction and an encoder of 55 um, as real devices have",
          number("C5", "factor_at_5"), at_least=1.5),
    Claim("C 6, Fig. 4", "compensation nearly doubles the stiffness (B = 15 Ns/m)",
          "corrected; trapezoid, 0.1 N of friction and an encoder of 55 um, as real devices have",
          number("C5", "factor_at_15"), at_least=1.5),
    Claim("C 6, Fig. 4", "compensation nearly doubles the stiffness (B = 0 Ns/m, backward Euler)",
          "port ledger: it limits what a wall can release, and does nothing else",
          ratio(number("C4", "at_0_ledger"), number("C4", "at_0_waves")), printed=2.0),
    Claim("C 6, Fig. 5(c)", "the balance falls below zero before compensation",
          "simulated hand; trapezoid: active by a hair, which this contact does not show",
          number("C5", "lowest_before_none_mj"), at_most=-1e-3, unit="mJ"),
    Claim("C 6, Fig. 5(c)", "after compensation it is almost that of the environment (distance)",
          "corrected", number("C5", "apart_from_environment_corrected"), printed=0.0),
    Claim("C 6, Fig. 5(b)", "forces agree in contact (device over environment)", "corrected",
          ratio(number("C5", "force_end_n"), number("C5", "contact_force_end_n")), printed=1.0,
          only="which is trivial: compared at rest, where nothing can tell them apart"),
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
          at_least=1.0, only="a twelfth of the way to the ideal"),
    Claim("D 5, Fig. 7", "with the filter the first natural frequency approaches the ideal (over "
          "the ideal, b = 80 Ns/m)", "loop solved; filter with its loop solved",
          ratio(number("D7", "first_peak_hz_b_80"), number("D7", "first_peak_hz_ideal")),
          printed=1.0),
    Claim("D 5, Fig. 6", "the filter leaves low frequencies alone (rendered stiffness with "
          "over without, b = 80 Ns/m)", "loop solved; filter with its loop solved",
          ratio(number("D6", "k_felt_b_80"), number("D3", "k_felt_b_80")), printed=1.0),
    Claim("D 6, Fig. 8, 10", "the filter takes the noise from the force (power beyond 60 Hz, "
          "without over with)", EQUIVALENT,
          lambda found: (found["D8"]["force_noise_n"] / found["D10"]["force_noise_n"]) ** 2,
          at_least=1.0),
    Claim("D 6, Fig. 9", "the wrong filter makes the system unstable (spectral radius)",
          EQUIVALENT, number("D9", "spectral_radius"), at_least=1.0),
    Claim("D 6, Fig. 10", "the designed filter does not (spectral radius)",
          EQUIVALENT, number("D10", "spectral_radius"), at_most=1.0),
    *(
        Claim("D 1", "filtering in the wave domain is robust against constant delay (spectral "
              f"radius, {delay} ms each way)", EQUIVALENT,
              number("D10", f"spectral_radius_delay_{delay}_ms"), at_most=1.0)
        for delay in (20, 100)
    ),
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
          ratio(number("E5", "least_gain_20"), number("E5", "plain")), at_least=1.0,
          only="with a position feedback that is not passive"),
    Claim("E 3.1", "the improvement is largely brought about by LP_2 (share of it that is left "
          "without position feedback)", "filter bank with LP_2 and K_p = 0 over K_p = 20",
          lambda found: (found["E5"]["least_gain_0"] - found["E5"]["plain"])
          / (found["E5"]["least_gain_20"] - found["E5"]["plain"]), at_least=0.5),
    Claim("E 3", "the filter bank keeps the channels passive (largest |LP_1| + |LP_2||HP|)",
          "filters of Table 1, any linear environment and local model",
          number("E5", "bank_table"), at_most=1.0 + 1e-9),
    Claim("E 3", "the filter bank keeps the channels passive (largest |LP_1| + |LP_2||HP|)",
          "HP of first order, 4 Hz, which the local model needs to reach the resonance",
          number("E5", "bank_lower"), at_most=1.0 + 1e-9),
    Claim("E 3", "the filter bank keeps the channels passive (largest gain of the returning wave)",
          "filters of Table 1, a contact that opens and closes",
          number("E5", "bank_switching_table"), at_most=1.0 + 1e-9),
    Claim("E 3.1", "stable with a local model of B_LM = 1 Ns/m (spectral radius)",
          "sampled spring and damper with its loop solved; stable from 3.0 Ns/m on",
          number("E5", "spectral_radius_damping_1"), at_most=1.0),
    Claim("E 3.2, Fig. 6(a)", "at rest K_p renders the environment's stiffness for every b",
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
