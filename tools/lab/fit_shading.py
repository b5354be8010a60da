#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks the constants of runtime_gl/shaders/common/movmf_shading.glsl against quadrature in double precision.

For every exponent s and lobe kappa, prints the relative L1 error over the hemisphere of half vectors (weighted by solid
angle) of four formulas: only the vMF shape, only the cosine-power shape, Han et al. 2007 eq. 20, and the blend in use.
Then prints the errors of the polynomial inverse of A(kappa) = coth kappa - 1/kappa and of the convolved Lambert term.
`fit_shading.py --fit` also tabulates other values of the blend's constant. `fit_shading.py --cosine` also tabulates
replacements of max(n . l, 0) under a highlight. Needs numpy. Takes about 5 s, or half a minute with --cosine."""
import sys

import numpy as np

SHAPE_BLEND = 1.4
KAPPA_POLYNOMIAL = (-0.20753, -0.12665, -1.04417, 0.90242)
LAMBERT_V = (0.25, 0.2343, 0.15232)
LAMBERT_G = (0.4117, 0.2857, -0.3658, 0.0080)

EXPONENTS = (1, 2, 3, 5, 10, 20, 50, 100, 200, 500, 1000, 2000)
KAPPAS = (0.5, 1, 2, 2.5, 3, 4, 5, 10, 20, 50, 100, 200, 500, 1e3, 1e4, 1e5)
NODES, WEIGHTS = np.polynomial.legendre.leggauss(600)


def bessel_i0_scaled(x):
    """Returns exp(-x) I_0(x). Uses numpy for x below 50, and the asymptotic series above 50 (relative error 2e-9)."""
    low = np.minimum(x, 50.0)
    y = 1.0 / np.maximum(x, 50.0)
    series = 1 + y / 8 + 9 * y**2 / 128 + 225 * y**3 / 3072 + 11025 * y**4 / 98304
    return np.where(x < 50.0, np.exp(-low) * np.i0(low), series * np.sqrt(y / (2 * np.pi)))


def convolve(profile, width, kappa, theta):
    """Returns the integral of f(n . w) vMF(n; mu, kappa) dn, where theta is the angle between mu and w. The integral
    around the axis w is I_0. The other integral is over the angle a between n and w, and ends where f (`width` = 9
    standard deviations) or the vMF is below 1e-17."""
    reach = 9 / np.sqrt(kappa)
    low, high = max(0.0, theta - reach), min(np.pi / 2, theta + reach, max(width, theta - reach))
    if high <= low:
        return 0.0
    a = low + (high - low) * (NODES + 1) / 2
    ring = kappa / -np.expm1(-2 * kappa) * np.exp(kappa * (np.cos(a - theta) - 1)) * bessel_i0_scaled(
        kappa * np.sin(a) * np.sin(theta))
    return float((WEIGHTS * profile(a) * ring * np.sin(a)).sum() * (high - low) / 2)


def spread(kappa):
    """Returns 1 - A(kappa) without cancellation."""
    return 1 / kappa - 2 / np.expm1(2 * kappa) if kappa < 300 else 1 / kappa


def kappa_of_spread(q, polynomial=KAPPA_POLYNOMIAL):
    a = 1 - q
    x = a * a
    p = sum(c * x**i for i, c in enumerate(polynomial))
    return a * (3 - x + x * (1 - x) * p) / (q * (2 - q))


def vmf(kappa, theta):
    return kappa / (2 * np.pi * -np.expm1(-2 * kappa)) * np.exp(-2 * kappa * np.sin(theta / 2) ** 2)


def blinn_phong(s, theta):
    return (s + 1) / (2 * np.pi) * np.maximum(np.cos(theta), 0) ** s


def blinn_phong_cases():
    nodes, weights = np.polynomial.legendre.leggauss(160)
    for s in EXPONENTS:
        for kappa in KAPPAS:
            d = spread(kappa)
            q = d + (1 - d) / (s + 2)
            high = min(np.pi / 2, 12 * np.sqrt(q))
            theta = high * (nodes + 1) / 2
            exact = np.array([convolve(lambda a: blinn_phong(s, a), 9 / np.sqrt(s), kappa, t) for t in theta])
            weight = weights * np.sin(theta)
            shape_vmf = vmf(kappa_of_spread(q), theta)
            shape_power = blinn_phong(max((1 - 2 * q) / q, 0), theta)
            paper = blinn_phong(kappa * s / (kappa + s), theta)

            def error(value, exact=exact, weight=weight):
                return 100 * (np.abs(value - exact) * weight).sum() / (exact * weight).sum()

            yield s, kappa, d, shape_vmf, shape_power, paper, error


def blend(s, d, shape_vmf, shape_power, constant):
    r = 1 - d
    w = r * r / (r * r + constant * d * (s + 2))
    return w * shape_power + (1 - w) * shape_vmf


def print_blinn_phong(cases):
    print("relative L1 error, %\n     s     kappa       vMF     power     eq.20     blend")
    for s, kappa, d, shape_vmf, shape_power, paper, error in cases:
        print(f"{s:6} {kappa:9g} {error(shape_vmf):9.3f} {error(shape_power):9.3f} {error(paper):9.3f} "
              f"{error(blend(s, d, shape_vmf, shape_power, SHAPE_BLEND)):9.3f}")


def print_kappa_inverse():
    kappa = np.logspace(-3, 5, 2000)
    q = np.array([spread(k) for k in kappa])
    print(f"inverse of A, kappa 1e-3..1e5: relative error at most {np.max(np.abs(kappa_of_spread(q) / kappa - 1)):.2e}")


def lambert(d, t):
    r = 1 - d
    m = r * t
    v = d * sum(c * r**i for i, c in enumerate(LAMBERT_V))
    x = np.minimum(m * m / v, 200)
    g = x * (LAMBERT_G[0] + LAMBERT_G[1] * r + LAMBERT_G[2] * r * r + LAMBERT_G[3] * x)
    return 0.5 * (m + np.sqrt(m * m + v * np.exp(-g)))


def lambert_tables():
    kappas = np.concatenate([np.logspace(-2, 2, 25), np.logspace(2.3, 4, 6)])
    t = np.linspace(0, 1, 81)
    upper = np.array([[convolve(np.cos, np.pi, k, np.arccos(c)) for c in t] for k in kappas])
    return kappas, t, upper


def print_lambert(tables):
    kappas, t, upper = tables
    weight = np.ones_like(t)
    weight[[0, -1]] = 0.5
    worst = [0.0, 0.0, 0.0]
    for kappa, exact in zip(kappas, upper):
        d = spread(kappa)
        # The equation F(t) - F(-t) = |r| t holds exactly for both the formula and the integral, so the absolute error
        # is the same in the lower half of the sphere.
        off = np.abs(lambert(d, t) - exact)
        both = exact + exact - (1 - d) * t
        worst = np.maximum(worst, [100 * (off * weight).sum() / (exact * weight).sum(),
                                   100 * 2 * (off * weight).sum() / (both * weight).sum(), off.max()])
    print(f"Lambert, kappa 0.01..1e4: relative L1 at most {worst[0]:.3f} % (upper half), {worst[1]:.3f} % (sphere); "
          f"absolute at most {worst[2]:.5f}")


def search_blend(cases):
    print("constant  worst of all  worst s >= 20  worst s >= 100   mean, %")
    for constant in np.arange(1.0, 2.6, 0.1):
        errors = {(s, k): error(blend(s, d, v, p, constant)) for s, k, d, v, p, _, error in cases}
        pick = [max(e for (s, _), e in errors.items() if s >= low) for low in (0, 20, 100)]
        print(f"{constant:8.1f} {pick[0]:13.3f} {pick[1]:14.3f} {pick[2]:15.3f} {np.mean(list(errors.values())):9.4f}")


def unit(v):
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def directions(random, count, degrees):
    """Draws directions uniformly within this many degrees of +z."""
    z = random.uniform(np.cos(np.radians(degrees)), 1, count)
    phi, radius = random.uniform(0, 2 * np.pi, count), np.sqrt(1 - z * z)
    return np.stack([radius * np.cos(phi), radius * np.sin(phi), z], -1)


def highlights(s, facet_kappa, kappa, h, mu, light):
    """Returns the integral of f(n . h) vMF(n) max(n . l, 0) dn, and the same integral without the cosine. Both use
    polar coordinates around the mean of the product of both vMFs. f is Blinn-Phong with exponent s, or the vMF of
    facet_kappa if s is None."""
    nodes, weights = np.polynomial.legendre.leggauss(48)
    total = facet_kappa * h + kappa * mu
    size = np.linalg.norm(total, axis=-1)
    middle = total / np.maximum(size, 1e-9)[:, None]
    side = unit(np.cross(np.where(np.abs(middle[:, 2:]) < 0.9, [0, 0, 1.0], [1.0, 0, 0]), middle))
    across = np.cross(middle, side)
    reach = np.minimum(np.pi, 8 / np.sqrt(np.maximum(size, 1e-3)))[:, None]
    theta = (reach * (nodes + 1) / 2)[:, :, None, None]
    phi = ((np.arange(64) + 0.5) * 2 * np.pi / 64)[None, None, :, None]
    n = (np.cos(theta) * middle[:, None, None] +
         np.sin(theta) * (np.cos(phi) * side[:, None, None] + np.sin(phi) * across[:, None, None]))
    angle = lambda w: np.arccos(np.clip(np.einsum("ijkc,ic->ijk", n, w), -1, 1))
    facets = vmf(facet_kappa, angle(h)) if s is None else blinn_phong(s, angle(h))
    cells = (weights * reach / 2 * np.sin(theta[:, :, 0, 0]))[:, :, None] * 2 * np.pi / 64
    value = facets * vmf(kappa, angle(mu)) * cells
    return (value * np.maximum(np.einsum("ijkc,ic->ijk", n, light), 0)).sum((1, 2)), value.sum((1, 2))


def print_highlight_cosine():
    print("highlight's cosine, relative L1 over l and the eye, lobes within 40 degrees of +z, %\n"
          "              f     kappa   lobe's mean    mu . l   at the mean of f vMF   mean over f vMF, used")
    random = np.random.default_rng(1)
    facets = [(f"Blinn-Phong {s}", s, kappa_of_spread(1 / (s + 2))) for s in (1, 2, 5, 20, 100, 500)]
    facets += [(f"vMF {k}", None, float(k)) for k in (2, 10, 50, 500)]
    for name, s, facet_kappa in facets:
        for kappa in (0.5, 2, 10, 50, 200, 1000):
            light, eye, mu = directions(random, 800, 90), directions(random, 800, 90), directions(random, 800, 40)
            h = unit(light + eye)
            exact, without = highlights(s, facet_kappa, kappa, h, mu, light)
            total = facet_kappa * h + kappa * mu
            size, mu_l = np.linalg.norm(total, axis=-1), (mu * light).sum(-1)
            n_l = (total * light).sum(-1) / size
            spreads = np.array([spread(k) for k in size])
            tried = (lambert(spread(kappa), mu_l), np.maximum(mu_l, 0), np.maximum(n_l, 0), lambert(spreads, n_l))
            errors = [100 * np.abs(without * cosine - exact).sum() / exact.sum() for cosine in tried]
            print(f"{name:>15} {kappa:9g} {errors[0]:13.2f} {errors[1]:9.2f} {errors[2]:22.2f} {errors[3]:23.2f}")


def main():
    if sys.argv[1:2] in (["-h"], ["--help"]):
        print(__doc__)
        return
    cases = list(blinn_phong_cases())
    print_blinn_phong(cases)
    print_kappa_inverse()
    print_lambert(lambert_tables())
    if "--fit" in sys.argv[1:]:
        search_blend(cases)
    if "--cosine" in sys.argv[1:]:
        print_highlight_cosine()


if __name__ == "__main__":
    main()
