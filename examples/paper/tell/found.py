# SPDX-License-Identifier: GPL-3.0-or-later
"""Chapter: what we found. Each claim of the paper, and whether this run supports it, with the number."""

from typing import NamedTuple

from measure.bound import PAPER_EPS
from methods import HALTON, NAMES, OWEN_SOBOL, SOBOL, SPRS
from tables import Data, one

from .bounded import time_lines
from .convergence import penumbra_slope, ratio_to_prs, settled_medians, way_ratio
from .words import percent, times

YES, PARTLY, NO = "supported", "partly", "not supported"


class Finding(NamedTuple):
    claim: str
    verdict: str
    number: str


def tell(data: Data) -> str:
    lines = ["| the paper says | these runs | the number |", "|---|---|---|"]
    lines += [f"| {f.claim} | **{f.verdict}** | {f.number} |" for f in findings(data)]
    return "## What we found\n\n" + "\n".join(lines) + "\n"


def findings(data: Data) -> list[Finding]:
    return [*_points(data), *_convergence(data), *_bounded(data)]


def _points(data: Data) -> list[Finding]:
    uneven = {r["sampler"]: r["discrepancy"] for r in data.read("fig1_discrepancies") if r["points"] == 16}
    costs = {(r["sampler"], r["reuse"]): r["made_ns"] for r in data.read("cost_of_a_point")}
    prs, sobol, halton = (costs[key] for key in (("PRS", "SAME"), ("SOBOL", "CONTINUED"), ("HALTON", "CONTINUED")))
    errors = {(r["sampler"], r["reuse"]): r["rmse"] for r in data.read("fig5_errors")}
    names = {NAMES[sampler]: (sampler, "SAME") for sampler in ("PRS", "SPRS", "SOBOL", "HALTON")}
    order = sorted(names, key=lambda name: errors[names[name]])
    stride = {r["picture"]: r["rmse"] for r in data.read("stride_errors")}
    best = min(v for k, v in uneven.items() if k != "PRS")
    return [
        Finding("The first 16 points of PRS are uneven, those of the others even (Fig. 1)",
                YES if all(uneven["PRS"] > v for k, v in uneven.items() if k != "PRS") else NO,
                f"L2 star discrepancy: PRS {uneven['PRS']:.3f}, best of the others {best:.3f}"),
        Finding("Low-discrepancy points cost no more than PRS, but for a slow Halton", YES if sobol < 1.5 * prs else NO,
                f"{prs:.0f} ns PRS, {sobol:.0f} ns Sobol', {halton:.0f} ns Halton, each point made anew"),
        Finding("Careless use of Sobol's period gives visible artifacts (Fig. 2)",
                YES if stride["striding"] > 1.5 * stride["careful"] else NO,
                f"taking every other point: error {times(stride['striding'] / stride['careful'])}"),
        Finding("Penumbra with 16 points: Halton at least as good as Sobol', then SPRS, PRS worst (Fig. 5)",
                YES if order == ["Halton", "Sobol'", "SPRS", "PRS"] else PARTLY if order[-1] == "PRS" else NO,
                "by RMSE, same points in each pixel: " + ", ".join(f"{n} {errors[names[n]]:.4f}" for n in order)),
    ]  # fmt: skip


def _convergence(data: Data) -> list[Finding]:
    medians = {k: {s: v for s, (v, _) in row.items()} for k, row in settled_medians(data).items()}
    slowest = sum(m["PRS"] >= max(m["SOBOL"], m["HALTON"]) for m in medians.values())
    sobol_wins = sum(m["SOBOL"] < m["HALTON"] for m in medians.values())
    count = len(medians)
    ratio = ratio_to_prs(data, "unoccluded", "HALTON", "SAME", 81)
    quantised = [way_ratio(data, s, "PRS 10^4, 8 bit, RMS", "HALTON") for s in ("unoccluded", "occluded")]
    others = {n: ratio_to_prs(data, "unoccluded", s, "SAME", 81)
              for n, s in (("SPRS", "SPRS"), ("Sobol'", "SOBOL"), ("Halton", "HALTON"))}  # fmt: skip
    slopes = {n: penumbra_slope(data, *k) for n, k in
              {"PRS": ("PRS", "SAME"), "SPRS": ("SPRS", "SAME"), "Owen-Sobol'": OWEN_SOBOL}.items()}  # fmt: skip
    owen = [ratio_to_prs(data, s, *OWEN_SOBOL, 64) for s in ("unoccluded", "occluded")]
    beaten = [[ratio_to_prs(data, scene, *method, 64) for method in (SPRS, SOBOL, HALTON)]
              for scene in ("unoccluded", "occluded")]  # fmt: skip
    return [
        Finding("PRS always converges slowest, whatever the luminaire's shape or the starting index (Fig. 6)",
                YES if slowest == count else PARTLY if slowest > 0.8 * count else NO,
                f"PRS slowest in {slowest} of {count} cases"),
        Finding("Halton converges fastest; Sobol' sometimes beats it", YES if 0 < sobol_wins < count / 2 else PARTLY,
                f"Sobol' settles before Halton in {sobol_wins} of {count} cases"),
        Finding("With 81 points PRS has almost 3 times the error of Halton (Fig. 7)",
                YES if 2.5 < ratio < 3.2 else PARTLY if ratio > 2 else NO,
                f"{ratio:.2f} with exact reference and floats; {quantised[0]:.2f} (with the sphere {quantised[1]:.2f}) "
                "with the paper's PRS reference and 8-bit pixels, which hide part of the difference"),
        Finding("Halton is the best of all at 81; SPRS, Sobol', Halton lie close, SPRS a little worse",
                YES if others["Halton"] > others["Sobol'"] > others["SPRS"] else NO,
                "PRS / it: " + ", ".join(f"{n} {v:.1f}" for n, v in others.items()) + " (same points in each pixel)"),
        Finding("Stratified and quasi-Monte Carlo have about the same asymptotic error",
                YES if abs(slopes["SPRS"] - slopes["Owen-Sobol'"]) < 0.08 else PARTLY,
                "slopes in the penumbra: " + ", ".join(f"{n} {v:.2f}" for n, v in slopes.items())),
        Finding("(not in the paper) Owen-scrambled (0,2) points are better than all the paper's samplers",
                YES if all(o > max(b) for o, b in zip(owen, beaten, strict=True)) else PARTLY,
                f"Owen-Sobol' at 64 points: error of PRS / {owen[0]:.0f} unoccluded, / {owen[1]:.1f} with the sphere"),
    ]  # fmt: skip


def _bounded(data: Data) -> list[Finding]:
    rows = data.read("fig9_errors")
    ways = {way: one(rows, qmc=SOBOL.label, method=way) for way in ("MC-FS", "MC-EBLS", "QMC-FS", "QMC-EBLS")}

    def gain(better: str, worse: str, column: str = "rmse") -> float:
        return ways[better][column] / ways[worse][column]

    lines = time_lines(data)
    fit, start = min(line.r_squared for line in lines), max(line.start / line.mean_seconds for line in lines)
    specks = {way: ways[way]["dark_specks"] for way in ways}
    bound = one(data.read("bound"), rule="PAPER", sampler="SOBOL", reuse="SAME", eps=PAPER_EPS)
    own = one(data.read("bound"), rule="BOUNDED", eps=PAPER_EPS)
    error, variance = (one(data.read("bound"), rule=rule, sampler="SOBOL", reuse="SAME", eps=PAPER_EPS)
                       for rule in ("standard error", "variance of the mean"))  # fmt: skip
    clear = max(gain("MC-EBLS", "MC-FS", "rmse_penumbra"), gain("QMC-EBLS", "QMC-FS", "rmse_penumbra"))
    fastest = min(ways, key=lambda way: ways[way]["seconds"])
    return [
        Finding("QMC with EBLS gives the best image (Fig. 9)",
                YES if min(ways, key=lambda way: ways[way]["rmse"]) == "QMC-EBLS" else PARTLY,
                f"RMSE {gain('QMC-EBLS', 'MC-FS'):.2f} of MC-FS, {gain('QMC-EBLS', 'MC-EBLS'):.2f} of MC-EBLS, "
                f"{gain('QMC-EBLS', 'QMC-FS'):.2f} of QMC-FS"),
        Finding("EBLS clearly improves both MC and QMC, most of all in the penumbra",
                YES if clear < 0.8 else PARTLY if clear < 1 else NO,
                f"penumbra RMSE of EBLS / FS at matched rays: MC {gain('MC-EBLS', 'MC-FS', 'rmse_penumbra'):.2f}, "
                f"QMC {gain('QMC-EBLS', 'QMC-FS', 'rmse_penumbra'):.2f}; whole picture {gain('MC-EBLS', 'MC-FS'):.2f}, "
                f"{gain('QMC-EBLS', 'QMC-FS'):.2f}"),
        Finding("EBLS puts its points into the penumbra",
                YES if ways["QMC-EBLS"]["points_penumbra"] > ways["QMC-EBLS"]["points_lit"] else NO,
                f"{ways['QMC-EBLS']['points_penumbra']:.0f} points a pixel there, "
                f"{ways['QMC-EBLS']['points_lit']:.0f} on lit surfaces"),
        Finding("MC-FS has dark specks in the penumbra, which EBLS reduces",
                YES if specks["MC-EBLS"] < specks["MC-FS"] else NO,
                ", ".join(f"{way} {percent(share)}" for way, share in specks.items()) + " of penumbra pixels"),
        Finding("QMC-EBLS needs the fewest rays and is fastest",
                YES if fastest == "QMC-EBLS" else PARTLY,
                f"rays MC-EBLS / QMC-EBLS {gain('MC-EBLS', 'QMC-EBLS', 'rays'):.2f} (paper 1.10); least CPU time: "
                f"{fastest} (EBLS traces packets of 16 rays and may stop inside one)"),
        Finding("Time is about proportional to rays",
                YES if fit > 0.9 and start < 0.2 else PARTLY if fit > 0.6 else NO,
                f"for each rule and sampler a line fits with R^2 of at least {fit:.2f}, but up to {percent(start)} of "
                "the mean time depends on the pixels, not on the rays"),
        Finding("EBLS computes each pixel to the accuracy asked for", NO if bound["beyond"] > 0.01 else YES,
                f"at eps = {PAPER_EPS:g} {percent(bound['beyond'])} of all pixels and "
                f"{percent(bound['beyond_penumbra'])} of the penumbra are beyond it, the 99th percentile of the error "
                f"is {bound['p99_over_eps']:.0f} eps; this engine's own rule misses {percent(own['beyond'])} "
                f"with {own['light_rays_per_pixel']:.0f} rays a pixel, not {bound['light_rays_per_pixel']:.0f}"),
        Finding("One can also stop when an estimate of the variance V(L) is below eps",
                YES if max(variance["beyond"], error["beyond"]) < 0.01 else PARTLY if error["beyond"] < 0.05 else NO,
                f"read literally, {percent(variance['beyond'])} of the pixels miss; as sqrt(V / n) < eps "
                f"{percent(error['beyond'])}, with {error['light_rays_per_pixel']:.0f} rays a pixel: V is "
                "that of random points, which Sobol' points beat"),
    ]  # fmt: skip
