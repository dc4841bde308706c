#!/usr/bin/env python3
"""Renders a flight over a vineyard with POV-Ray, with exact truth beside it: an outside witness for the height.

Nothing is shared with Furrow's simulator: plants are volumes of leaves instead of envelopes, and renderer, light and
ground are another program's. Needs Debian's povray and libjpeg-turbo-progs; about ten seconds a picture on one core.

    tests/witness/vineyard.py OUT --shape hedge --flight 345 --seed 1
    furrow run OUT --truth OUT/truth.csv --out out/witness

OUT holds frames/, truth.csv, camera_true.yaml, airdata.csv and project.yaml, as a simulated flight does, and README.txt
with what the plants measure from above.
"""
import argparse, math, os, random, subprocess, sys
from concurrent.futures import ThreadPoolExecutor
from flight import FLIGHTS, Farm, Lens, axes, cross, shots_of, write_log, write_project, write_truth

LENS = Lens()
W, H, FX, FY, CX, CY = LENS.width, LENS.height, LENS.fx, LENS.fy, LENS.cx, LENS.cy
SPACING, HALF, HEIGHT = 3.0, 0.60, 1.70
LEAF = 0.055           # radius, m
PLANT = 1.0            # length of row per plant, m
VARIANTS = 10


def half_width_at(shape, z):
    """Half width of the canopy's envelope at height z; negative outside."""
    if shape == "box":
        return HALF if 0.65 <= z <= HEIGHT else -1
    if shape == "v":
        return (0.2 + 0.4 * (z - 0.75) / (HEIGHT - 0.75)) if 0.75 <= z <= HEIGHT else -1
    bottom = 0.6
    middle, reach = 0.5 * (HEIGHT + bottom), 0.5 * (HEIGHT - bottom)
    n = 2.6 if shape == "hedge" else 2.0
    a = abs((z - middle) / reach)
    return HALF * (1 - a ** n) ** (1 / n) if a <= 1 else -1


def leaves_of(shape, rng, scale_w, scale_h, inset):
    """Leaves of one plant: (centre, normal, radius, shade). Denser towards the envelope, as foliage is."""
    leaves, wanted = [], 950
    w_factor = rng.gauss(1, 0.10) if shape == "lumpy" else rng.gauss(1, 0.03)
    h_factor = rng.gauss(1, 0.03) if shape == "lumpy" else rng.gauss(1, 0.008)
    while len(leaves) < wanted:
        x, z = rng.uniform(-0.56, 0.56) * PLANT, rng.uniform(0.5, HEIGHT)
        w = half_width_at(shape, z)
        if w < 0:
            continue
        if shape == "lumpy":
            w *= math.sqrt(max(0.0, 1 - 0.75 * (x / PLANT) ** 2))
        y = rng.uniform(-1, 1) * w
        above = half_width_at(shape, min(z + 0.18, HEIGHT - 1e-6))
        inner = abs(y) < w - 0.2 and z < HEIGHT - 0.22 and above > 0 and abs(y) < above
        if inner and rng.random() < 0.8:
            continue
        # keep discs inside the envelope
        y = math.copysign(max(0, abs(y) - inset * (abs(y) / max(w, 1e-6))), y) * scale_w * w_factor
        z = (0.5 + (z - 0.5) * scale_h * h_factor)
        out = (rng.gauss(0, 0.5), math.copysign(0.5, y) + rng.gauss(0, 0.5), 0.7 + rng.gauss(0, 0.4))
        n = math.sqrt(sum(c * c for c in out))
        leaves.append(((x, y, z), tuple(c / n for c in out), LEAF * rng.uniform(0.7, 1.25), rng.randrange(6)))
    return leaves


def measured_edges(plants):
    """Half-coverage half width and mean first-hit height, seen from above."""
    cell, nx = 0.02, int(PLANT / 0.02)
    count = {}
    tops = {}
    for leaves in plants:
        top = {}
        for (x, y, z), n, r, _ in leaves:
            rx = r * 0.85
            for i in range(int((x - rx) / cell), int((x + rx) / cell) + 1):
                for j in range(int(math.floor((y - rx) / cell)), int(math.floor((y + rx) / cell)) + 1):
                    if ((i + .5) * cell - x) ** 2 + ((j + .5) * cell - y) ** 2 < rx * rx * abs(n[2]):
                        k = ((i % nx), j)
                        top[k] = max(top.get(k, 0), z)
        for (i, j), z in top.items():
            count[j] = count.get(j, 0) + 1
            if abs((j + .5) * cell) < 0.8 * HALF:
                tops.setdefault("z", []).append(z)
    full = nx * len(plants)
    middle = sum(count.get(j, 0) for j in range(-5, 5)) / 10 / full
    edges = []
    for sign in (1, -1):
        j = 0
        while count.get(j if sign > 0 else -1 - j, 0) / full > 0.5 * middle and j < 80:
            j += 1
        edges.append(j * cell)
    return sum(edges) / 2, sum(tops["z"]) / len(tops["z"])


def make_plants(shape, rng, top):
    """Plants whose measured half width and height equal HALF and HEIGHT, or, with top "envelope", as the shape itself
    says: all leaves below HEIGHT."""
    scale_w, scale_h = 1.0, 1.0
    if top == "envelope":
        plants = [leaves_of(shape, rng, scale_w, scale_h, 0.03) for _ in range(VARIANTS)]
        return plants, measured_edges(plants)
    state = rng.getstate()
    for _ in range(4):
        rng.setstate(state)
        plants = [leaves_of(shape, rng, scale_w, scale_h, 0.03) for _ in range(VARIANTS)]
        w, h = measured_edges(plants)
        scale_w *= HALF / w
        scale_h *= (HEIGHT - 0.5) / (h - 0.5)
    rng.setstate(state)
    plants = [leaves_of(shape, rng, scale_w, scale_h, 0.03) for _ in range(VARIANTS)]
    return plants, measured_edges(plants)


def vec(v):
    return "<%.5f,%.5f,%.5f>" % tuple(v)


def mesh_text(leaves, rng):
    """A leaf is a folded hexagon-like shape of four triangles."""
    vertices, faces = [], []
    for c, n, r, shade in leaves:
        t = (rng.gauss(0, 1), rng.gauss(0, 1), rng.gauss(0, 1))
        a = cross(n, t)
        l = math.sqrt(sum(x * x for x in a)) or 1
        a = tuple(x / l for x in a)
        b = cross(n, a)
        base = len(vertices)
        for u, v, lift in ((1.1, 0, 0), (0.3, 0.85, .12), (-0.8, 0.6, .1), (-0.8, -0.6, .1), (0.3, -0.85, .12)):
            vertices.append(tuple(c[i] + r * (u * a[i] + v * b[i] + lift * n[i]) for i in range(3)))
        for f in ((0, 1, 2), (0, 2, 3), (0, 3, 4)):
            faces.append((tuple(base + k for k in f), shade))
    out = ["mesh2 { vertex_vectors { %d,%s }" % (len(vertices), ",".join(map(vec, vertices)))]
    out.append(" texture_list { 6, " + " ".join("texture{L%d}" % k for k in range(6)) + " }")
    out.append(" face_indices { %d,%s } }" % (len(faces), ",".join("<%d,%d,%d>,%d" % (*f, s) for f, s in faces)))
    return "\n".join(out)


def scene_text(shape, rng, top):
    plants, measured = make_plants(shape, rng, top)
    hue = rng.uniform(-0.02, 0.02)
    text = ["#version 3.7;", "global_settings { assumed_gamma 1.0 max_trace_level 3 }"]
    for k in range(6):
        g = 0.16 + 0.022 * k
        text.append("#declare L%d = texture { pigment { rgb <%.3f,%.3f,%.3f> } finish { diffuse 0.65,0.35 ambient 0 "
                    "specular 0.08 roughness 0.08 } };" % (k, (0.52 + hue) * g, g, 0.20 * g))
    for i, leaves in enumerate(plants):
        text.append("#declare P%d = %s;" % (i, mesh_text(leaves, rng)))
    tuft = []
    for _ in range(40):
        x, y, h = rng.gauss(0, .1), rng.gauss(0, .1), rng.uniform(.03, .12)
        w = rng.uniform(.004, .012)
        dx, dy = rng.gauss(0, .04), rng.gauss(0, .04)
        tuft.append("triangle { <%.4f,%.4f,0>,<%.4f,%.4f,0>,<%.4f,%.4f,%.4f> }"
                    % (x - w, y, x + w, y, x + dx, y + dy, h))
    text.append("#declare T = mesh { %s texture { pigment { rgb <.10,.17,.035> } finish { diffuse .65,.3 } } };"
                % "\n".join(tuft))
    sun_el, sun_az = math.radians(rng.uniform(30, 65)), math.radians(rng.uniform(0, 360))
    sun = (math.cos(sun_el) * math.cos(sun_az), math.cos(sun_el) * math.sin(sun_az), math.sin(sun_el))
    text.append("light_source { %s*5000 rgb <1.25,1.2,1.08> parallel point_at <0,0,0> }" % vec(sun))
    text.append("light_source { <0,0,5000> rgb <.30,.34,.40> shadowless parallel point_at <0,0,0> }")
    text.append("light_source { <-3000,2000,2500> rgb <.10,.11,.13> shadowless parallel point_at <0,0,0> }")
    text.append("light_source { <3000,-2000,2500> rgb <.10,.11,.13> shadowless parallel point_at <0,0,0> }")
    text.append("sky_sphere { pigment { gradient z color_map { [0 rgb <.72,.78,.85>] [.25 rgb <.40,.55,.85>] "
                "[1 rgb <.18,.35,.75>] } } }")
    soil = [0.30 * rng.uniform(.8, 1.2), 0.22 * rng.uniform(.85, 1.15), 0.14 * rng.uniform(.8, 1.2)]
    strip = rng.choice([0.0, 0.35, 0.6])  # half width of the mown strip in the alley
    text.append("#declare Soil = pigment { bozo turbulence .8 scale .15 color_map { [0 rgb %s*.75] [.5 rgb %s] "
                "[1 rgb %s*1.2] } };" % ((vec(soil),) * 3))
    text.append("#declare Grass = pigment { bozo turbulence .6 scale .07 color_map { [0 rgb <.10,.16,.035>] "
                "[.55 rgb <.14,.19,.05>] [.8 rgb %s] [1 rgb %s*.9] } };" % ((vec(soil),) * 2))
    a, b = 0.5 - strip / SPACING, 0.5 + strip / SPACING
    if strip:
        ground = ("gradient y pigment_map { [0 Soil] [%.4f Soil] [%.4f Grass] [%.4f Grass] [%.4f Soil] [1 Soil] } "
                  "scale %.3f turbulence .01" % (a - .04, a + .02, b - .02, b + .04, SPACING))
    else:
        ground = "Soil"
    text.append("plane { z, 0 texture { pigment { %s } finish { diffuse .75 } normal { granite .35 scale .2 } } }"
                % ground)
    planting = {k: rng.gauss(0, 0.015) for k in range(-30, 31)}
    sides = 30
    text.append("union {")
    for k in range(-sides, sides + 1):
        x = -8.0
        while x < 130:
            if rng.random() > 0.02:
                flip = rng.choice((0, 180))
                text.append("object { P%d rotate z*%d translate <%.3f,%.3f,0> }" %
                            (rng.randrange(VARIANTS), flip, x, k * SPACING + planting[k] + rng.gauss(0, .015)))
            x += PLANT
    text.append("}")
    text.append("union {")
    for k in range(-8, 9):
        for x in range(-8, 60):
            text.append("cylinder { <%.3f,%.3f,0>,<%.3f,%.3f,.8>, .02 pigment { rgb <.12,.08,.05> } }" %
                        (x, k * SPACING + planting[k], x + .02, k * SPACING + planting[k]))
        for x in range(-6, 60, 6):
            text.append("cylinder { <%.3f,%.3f,0>,<%.3f,%.3f,1.85>, .03 pigment { rgb <.35,.33,.31> } }" %
                        (x + .5, k * SPACING + planting[k], x + .5, k * SPACING + planting[k]))
    text.append("}")
    text.append("union {")
    for _ in range(2500):
        y = rng.uniform(-20, 20)
        text.append("object { T scale %.2f rotate z*%d translate <%.3f,%.3f,0> }"
                    % (rng.uniform(.5, 1.6), rng.randrange(360), rng.uniform(0, 60), y))
    text.append("}")
    return "\n".join(text), measured, strip


def camera_text(shot):
    f, right, down = axes(shot)
    ox, oy = (W / 2 - 0.5 - CX) / FX, (H / 2 - 0.5 - CY) / FY
    d = tuple(f[i] + ox * right[i] + oy * down[i] for i in range(3))
    triple = "<%.9f,%.9f,%.9f>"
    return (f"camera {{ perspective location {triple} direction {triple} right {triple} up {triple} }}"
            % (shot["x"], shot["y"], shot["z"], *d, *(a * W / FX for a in right), *(-a * H / FY for a in down)))


def render(out, i, shot):
    name = "shot-%04d" % (i + 1)
    pov, ppm = (os.path.join(out, "work", name + e) for e in (".pov", ".ppm"))
    jpg = os.path.join(out, "frames", name + ".jpg")
    if os.path.exists(jpg):
        return
    open(pov, "w").write('#include "scene.inc"\n' + camera_text(shot) + "\n")
    done = subprocess.run(["povray", "+I" + pov, "+O" + ppm, "+FP", "+W%d" % W, "+H%d" % H, "+A0.08", "+AM1", "+R2",
                           "-D", "-V", "+WT1", "-GA", "File_Gamma=sRGB", "+L" + os.path.join(out, "work")],
                          capture_output=True, text=True)
    if done.returncode:
        sys.exit(done.stderr[-3000:])
    with open(jpg + ".part", "wb") as f:
        subprocess.run(["cjpeg", "-quality", "92", ppm], check=True, stdout=f)
    os.rename(jpg + ".part", jpg)
    os.remove(ppm)


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("out")
    p.add_argument("--shape", default="hedge", choices=["hedge", "box", "v", "lumpy"],
                   help="cross-section: superellipse, box, V, or ellipses that differ from plant to plant")
    p.add_argument("--top", default="first-hit", choices=["first-hit", "envelope"],
                   help="what stands at the rows' height: the mean of the leaves first hit from above, or the highest")
    p.add_argument("--flight", default="345", choices=sorted(FLIGHTS))
    p.add_argument("--seed", type=int, default=1)
    p.add_argument("--shots", type=int, default=12, help="per leg")
    p.add_argument("--jobs", type=int, default=1)
    args = p.parse_args()
    rng = random.Random("%s %s %d" % (args.shape, args.flight, args.seed))
    for d in ("work", "frames"):
        os.makedirs(os.path.join(args.out, d), exist_ok=True)
    text, (width, height), strip = scene_text(args.shape, rng, args.top)
    open(os.path.join(args.out, "work", "scene.inc"), "w").write(text)
    shots = shots_of(args.flight, args.shots, rng)
    farm = Farm(SPACING, HALF, HEIGHT)
    write_truth(args.out, shots, farm)
    write_project(args.out, "witness-%s-%s-%d" % (args.shape, args.flight, args.seed), farm, LENS)
    write_log(args.out, shots, rng, farm)
    open(os.path.join(args.out, "README.txt"), "w").write(
        "POV-Ray, shape %s, top %s, flight %s, seed %d. Seen from above the plants measure: half width %.3f m (half "
        "coverage), mean first hit %.3f m (nominal %.2f and %.2f). Strip half width %.2f m.\n"
        % (args.shape, args.top, args.flight, args.seed, width, height, HALF, HEIGHT, strip))
    with ThreadPoolExecutor(args.jobs) as pool:
        list(pool.map(lambda x: render(args.out, *x), enumerate(shots)))


if __name__ == "__main__":
    main()
