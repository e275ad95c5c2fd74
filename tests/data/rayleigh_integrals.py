"""Computes rayleigh_integrals.json from rayleigh_reference_public.json: python3 rayleigh_integrals.py [PROCESSES]; needs numpy, some minutes.

Along each ray, per species and channel, the integral of scattering coefficient times transmittance to the camera and from the Sun, where the Sun shines: the
reference's radiance is the sum over the species of integral times phase function. Written from the fields `method` and `units` of the reference alone.

Panels are cut at the shells below, at the ray's perigee, at the edge of the planet's shadow, and where the sunlight grazes a shell; each is divided finely
towards its ends, where the integrand may have a square root. 20-point Gauss-Legendre on each part; columns by the same rule on the shells.
A line is given by `q0` = p^2 - 1 of its perigee p; lengths are in planet radii from there. `q`: |x|^2 - 1, which keeps its digits near the ground.
"""
import json
import math
import multiprocessing
import pathlib
import sys

import numpy as np

FOLDER = pathlib.Path(__file__).parent
NODES, WEIGHTS = np.polynomial.legendre.leggauss(20)
# Ends of the parts of a panel.
PARTS = [0, 0.001, 0.02, 0.15, 0.5, 0.85, 0.98, 0.999, 1]
# Shells of an exponential profile, in scale heights.
SCALE_HEIGHTS = [0.25, 0.5, 1, 1.5, 2, 3, 4, 5, 6, 8, 10, 12, 15, 20, 25, 30, 40]


def gauss(a, b):
    return 0.5 * (a + b) + 0.5 * (b - a) * NODES, 0.5 * (b - a) * WEIGHTS


def height(q):
    return q / (1 + np.sqrt(1 + q))


class Species:
    def __init__(self, s, radius_km):
        self.is_tent = s["profile"] == "tent"
        if self.is_tent:
            self.centre, self.half_width = s["centre_km"] / radius_km, s["half_width_km"] / radius_km
        else:
            self.scale_height = s["scale_height_km"] / radius_km
        self.scattering, self.extinction = (np.array(s[k]) * radius_km * 1000 for k in ("scattering_per_m", "extinction_per_m"))

    def density(self, h):
        return np.maximum(0, 1 - abs(h - self.centre) / self.half_width) if self.is_tent else np.exp(-h / self.scale_height)


class Air:
    def __init__(self, a):
        radius_km = a["planet_radius_km"]
        self.top = a["top_km"] / radius_km
        self.species = [Species(s, radius_km) for s in a["species"]]
        shells = {self.top}
        for s in self.species:
            if s.is_tent:
                shells |= {s.centre - s.half_width, s.centre, s.centre + s.half_width}
            else:
                shells |= {k * s.scale_height for k in SCALE_HEIGHTS if k * s.scale_height < self.top}
        self.shells = sorted(shells)

    def depth(self, q0, a, b):
        """Optical depth per channel along a line, from a to b."""
        cuts = {a, b} | ({0.0} if a < 0 < b else set())
        for h in self.shells:
            t = h * (2 + h) - q0
            if t > 0:
                cuts |= {c for c in (math.sqrt(t), -math.sqrt(t)) if a < c < b}
        cuts = sorted(cuts)
        columns = np.zeros(len(self.species))
        for u, v in zip(cuts, cuts[1:]):
            s, w = gauss(u, v)
            h = height(q0 + s * s)
            columns += [w @ species.density(h) for species in self.species]
        return columns @ np.array([s.extinction for s in self.species])

    def integrals(self, camera, direction, sun):
        """One row per species, one column per channel."""
        result = np.zeros((len(self.species), 3))
        start = camera @ direction
        perigee = camera - direction * start
        distance = np.linalg.norm(camera)
        q0 = (distance - 1) * (distance + 1) - start * start
        top_q = self.top * (2 + self.top)
        if q0 >= top_q:
            return result
        exit = math.sqrt(top_q - q0)
        first = max(start, -exit)
        last = -math.sqrt(-q0) if q0 < 0 and start < 0 else exit
        if first >= last:
            return result
        to_sun, cosine = perigee @ sun, direction @ sun

        def tangents(q):
            """Where sunlight grazes a shell."""
            a, b, c = 1 - cosine * cosine, -to_sun * cosine, q0 - q - to_sun * to_sun
            d = b * b - a * c
            return [] if d < 0 or a == 0 else [(-b - math.sqrt(d)) / a, (-b + math.sqrt(d)) / a]

        cuts = [first, last, 0, *tangents(0)] + ([-to_sun / cosine] if cosine else [])
        for h in self.shells:
            q = h * (2 + h)
            if q > q0:
                cuts += [math.sqrt(q - q0), -math.sqrt(q - q0)]
            cuts += tangents(q)
        cuts = sorted({x for x in cuts if first <= x <= last})
        for u, v in zip(cuts, cuts[1:]):
            for p, r in zip(PARTS, PARTS[1:]):
                for s, w in zip(*gauss(u + (v - u) * p, u + (v - u) * r)):
                    q, sunward = q0 + s * s, to_sun + cosine * s
                    sun_q0 = q - sunward * sunward
                    if sunward < 0 and sun_q0 < 0:
                        continue
                    depth = self.depth(q0, first, s) + self.depth(sun_q0, sunward, math.sqrt(max(0, top_q - sun_q0)))
                    h = height(q)
                    result += [w * species.density(h) * species.scattering * np.exp(-depth) for species in self.species]
        return result


REFERENCE = json.loads((FOLDER / "rayleigh_reference_public.json").read_text())
AIRS = {name: Air(a) for name, a in REFERENCE["atmospheres"].items()}


def of_ray(ray):
    # Nothing is lit: the reference says so.
    if not any(ray["radiance"]):
        return [[0.0] * 3 for _ in AIRS[ray["atm"]].species]
    camera, direction, sun = (np.array(ray[k], dtype=float) for k in ("cam", "dir", "sun"))
    rows = AIRS[ray["atm"]].integrals(camera, direction / np.linalg.norm(direction), sun / np.linalg.norm(sun))
    return [[float(f"{x:.13g}") for x in row] for row in rows]


HEADER = [
    "For each ray of rayleigh_reference_public.json, in its order, one triple (red, green, blue) per species of its atmosphere: the integral along the ray of",
    "scattering coefficient times transmittance to the camera and from the Sun, outside the planet's shadow; no unit. The sum over the species of integral times",
    "phase function (1/sr, at the cosine dir . sun) is the reference's radiance. So a phase function may change while this file stays.",
    "Computed by rayleigh_integrals.py; with the functions of the reference it gives all radiances of the reference to REACHED (relative).",
]


def main():
    processes = int(sys.argv[1]) if len(sys.argv) > 1 else None
    with multiprocessing.Pool(processes) as pool:
        rays = pool.map(of_ray, REFERENCE["rays"], chunksize=1)
    worst = 0.0
    for ray, integrals in zip(REFERENCE["rays"], rays):
        direction, sun = (np.array(ray[k], dtype=float) for k in ("dir", "sun"))
        mu = direction @ sun / np.linalg.norm(direction) / np.linalg.norm(sun)
        total = np.zeros(3)
        for s, integral in zip(REFERENCE["atmospheres"][ray["atm"]]["species"], integrals):
            if s["phase"] == "rayleigh":
                total += 3 / (16 * math.pi) * (1 + mu * mu) * np.array(integral)
            elif s["phase"] == "hg":
                g = s["g"]
                total += (1 - g * g) / (4 * math.pi * (1 + g * g - 2 * g * mu) ** 1.5) * np.array(integral)
        for found, given in zip(total, ray["radiance"]):
            worst = max(worst, abs(found - given) / max(given, 1e-12))
    lines = ",\n".join("  " + json.dumps(integrals, separators=(",", ":")) for integrals in rays)
    header = ",\n".join("  " + json.dumps(line.replace("REACHED", f"{worst:.1e}")) for line in HEADER)
    (FOLDER / "rayleigh_integrals.json").write_text(f'{{\n "method": [\n{header}\n ],\n "rays": [\n{lines}\n ]\n}}\n')
    print("worst relative difference", worst)


if __name__ == "__main__":
    main()
