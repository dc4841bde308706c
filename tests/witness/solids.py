#!/usr/bin/env python3
"""Draws flights over fields of smooth solids, as a plain renderer would: what Furrow must cope with besides leaves.

Rows are prisms of one cross-section, or ellipsoids one behind the other; the top is the solid's own. The seed draws
the look: colours, textures or none, light (none, at the camera, sun, hard shadows), mown strips, sky, haze,
antialiasing, noise, lens distortion, JPEG or PNG. Nothing is shared with Furrow's simulator. Needs Debian's
python3-opencv; half a second a picture on one core, ellipsoids two.

    tests/witness/solids.py OUT --shape box --look flat --flight 345 --seed 1
    furrow run OUT --truth OUT/truth.csv --out out/witness

A cross-section seen from the camera is a list of angles about the direction of the rows: edges of the solids, nearest
row first, each hiding what stands behind. Every pixel looks its own angle up, which is exact for any number of rows.
"""
import argparse, math, os, random
import cv2
import numpy as np
from flight import FLIGHTS, Farm, Lens, axes, shots_of, write_log, write_project, write_truth

ROWS, X_END = 45, 160.0  # rows on either side; they run from 140 - X_END to X_END, m
TEXELS = 4               # per cell of noise
SHAPES = ["box", "round", "v", "gable", "ellipse", "bushes"]
LOOKS = ["flat", "lit", "textured", "shadow", "green", "dull"]


def cross_section(shape, farm, bottom):
    """Corners (y, z) of the convex cross-section, counter-clockwise."""
    w, h = farm.half_width_m, farm.height_m
    if shape in ("box", "v", "gable"):
        below, above = {"box": (w, w), "v": (.35 * w, w), "gable": (w, .12 * w)}[shape]
        return [(below, bottom), (above, h), (-above, h), (-below, bottom)]
    if shape == "round":
        r = 0.6 * w
        arc = [(w * math.cos(a), h - r + r * math.sin(a)) for a in np.linspace(0, math.pi, 25)]
        return [(w, bottom)] + arc + [(-w, bottom)]
    middle, reach = 0.5 * (h + bottom), 0.5 * (h - bottom)
    return [(w * math.cos(a), middle + reach * math.sin(a)) for a in np.linspace(0, 2 * math.pi, 48, endpoint=False)]


def draw_look(rng, look):
    """Everything about the picture that is not geometry."""
    def colour(*choices):
        return np.array([max(0.01, b * rng.uniform(.85, 1.15)) for b in rng.choice(choices)], np.float32)
    green = [(.20, .45, .12), (.10, .30, .08), (.28, .38, .14), (.13, .34, .20), (.35, .55, .20), (.0, .5, .0)]
    soil = [(.45, .33, .22), (.55, .45, .34), (.30, .22, .16), (.62, .55, .42), (.50, .30, .20), (.5, .5, .5)]
    c = {}
    c["canopy"] = colour(*([(.30, .36, .20), (.22, .28, .18), (.33, .35, .22)] if look == "dull" else green))
    c["ground"] = colour(*([(.30, .48, .18), (.38, .46, .22), (.42, .50, .25)] if look == "green" else soil))
    if look == "green":
        c["canopy"] = colour((.12, .28, .08), (.10, .30, .12), (.16, .30, .10))
    mown = rng.random() < (.5 if look in ("textured", "shadow", "dull") else 0)
    c["strip"] = colour((.32, .42, .18)) if mown else None
    c["light"] = {"flat": rng.choice(["none", "camera"]), "lit": "sun", "shadow": "shadow"}.get(
        look, rng.choice(["sun", "shadow", "camera"]))
    c["leaf"] = 0.0 if look in ("flat", "lit") else rng.uniform(.1, .5)  # contrast of textures
    c["soil"] = 0.0 if look == "flat" else rng.uniform(.03, .25)
    c["cell"] = rng.choice([.03, .06, .12])  # size of a texture's grain, m
    c["sky"] = np.array(rng.choice([(.45, .65, .95), (1, 1, 1), (.8, .85, .9), (0, 0, 0), (.1, .2, .4)]), np.float32)
    c["haze_m"] = rng.choice([None, None, 120.0, 300.0])
    c["antialias"], c["noise"] = rng.random() < .6, rng.choice([0, 0, 1.5, 4.0])
    c["quality"] = rng.choice([70, 80, 90, 95, None])  # None: PNG
    el, az = math.radians(rng.uniform(25, 75)), math.radians(rng.uniform(0, 360))
    c["sun"] = np.array([math.cos(el) * math.cos(az), math.cos(el) * math.sin(az), math.sin(el)])
    c["gain"], c["ambient"] = rng.uniform(.9, 1.6), rng.uniform(.25, .6)
    return c


def noise_levels(seed):
    """A tile of noise around 0 of one-sigma about 1, and its averages over 2, 4, 8, ... texels."""
    fine, coarse = (cv2.resize(np.random.default_rng([seed, n]).standard_normal((n, n)).astype(np.float32),
                               (1024, 1024), interpolation=cv2.INTER_CUBIC) for n in (1024 // TEXELS, 32))
    levels = [fine + 0.6 * coarse]
    while levels[-1].shape[0] > 16:
        levels.append(cv2.resize(levels[-1], None, fx=.5, fy=.5, interpolation=cv2.INTER_AREA))
    return levels


def texture(levels, a, b, footprint):
    """Noise at (a, b), averaged as far as a pixel's footprint asks, all in cells."""
    a, b, footprint = a * TEXELS, b * TEXELS, footprint * TEXELS
    level = np.clip(np.log2(np.maximum(footprint, 1e-6)), 0, len(levels) - 1).astype(np.int8)
    value = np.zeros(a.shape, np.float32)
    for k, tile in enumerate(levels):
        here = level == k
        i, j = (np.floor(x[here] * 0.5 ** k).astype(np.int64) % tile.shape[0] for x in (a, b))
        value[here] = tile[j, i]
    return value


def seen_edges(corners, farm, camera):
    """Angles from straight down, ascending, and between each two of them the row and edge that is seen (row None:
    ground). Edge e runs from corner e to the next."""
    (y0, z0), spans, lo, hi = camera, [], 9, -9
    for row in sorted(range(-ROWS, ROWS + 1), key=lambda k: abs(k * farm.spacing_m - y0)):
        y = [c[0] + row * farm.spacing_m - y0 for c in corners]
        z, own = [c[1] - z0 for c in corners], []
        for e in range(len(corners)):
            f = (e + 1) % len(corners)
            if (y[f] - y[e]) * z[e] - (z[f] - z[e]) * y[e] > 0:  # faces the camera
                own.append((math.atan2(y[f], -z[f]), math.atan2(y[e], -z[e]), row, e))
        first, last = min(own)[0], max(own)[1]
        low, high = (-9, 9) if not spans else (hi, 9) if last > hi else (-9, lo)  # what nearer rows leave of it
        lo, hi = min(lo, first), max(hi, last)
        spans += [(max(a, low), min(b, high), k, e) for a, b, k, e in own if min(b, high) > max(a, low)]
    angles, what = [], [(None, -1)]
    for a, b, row, e in sorted(spans):
        if angles and abs(angles[-1] - a) < 1e-12:
            del angles[-1], what[-1]
        angles += [a, b]
        what += [(row, e), (None, -1)]
    return np.array(angles), what


def prisms(corners, farm, origin, d):
    """First hit of every ray: distance, edge (-1 ground, -2 nothing) and row."""
    angles, what = seen_edges(corners, farm, (origin[1], origin[2]))
    below = d[2] < -1e-6
    at = np.searchsorted(angles, np.arctan2(d[1], -d[2]))
    rows, edge = (np.array(w, np.int16)[at] for w in zip(*((row or 0, e) for row, e in what)))
    edge[~below] = -2
    ground = np.where(below, origin[2] / np.maximum(-d[2], 1e-6), np.inf)
    c = np.array(corners + [corners[0]])
    normal = np.stack([c[1:, 1] - c[:-1, 1], c[:-1, 0] - c[1:, 0]])
    normal = np.hstack([normal / np.hypot(*normal), [[0, 0], [1, 1]]])  # the last two: nothing, ground
    ny, nz = normal[0][edge], normal[1][edge]
    corner = np.vstack([c[:-1], [[0, 0], [0, 0]]])
    py, pz = corner[:, 0][edge] + rows * farm.spacing_m - origin[1], corner[:, 1][edge] - origin[2]
    with np.errstate(divide="ignore", invalid="ignore"):
        t = np.where(edge >= 0, (ny * py + nz * pz) / (ny * d[1] + nz * d[2]), ground)
    outside = (edge >= 0) & (np.abs(origin[0] + t * d[0] - 70) > X_END - 70)
    edge[outside], t[outside] = -1, ground[outside]
    normal = np.stack([np.zeros_like(t), np.where(edge >= 0, ny, 0), np.where(edge >= 0, nz, 1)])
    return t.astype(np.float32), edge, rows, normal.astype(np.float32)


def in_shadow(corners, farm, y, z, edge, row, sun):
    """Whether a solid of another row stands between a point and the sun."""
    lean = sun[1] / sun[2]
    reach = [c[0] - c[1] * lean for c in corners]
    middle, half, foot = 0.5 * (min(reach) + max(reach)), 0.5 * (max(reach) - min(reach)), y - z * lean
    dark = np.zeros(y.shape, bool)
    for k in range(-4, 5):
        other = np.round(y / farm.spacing_m) + k
        toward = (other * farm.spacing_m - y) * np.sign(lean) > -farm.half_width_m
        dark |= (np.abs(foot - other * farm.spacing_m - middle) < half) & toward & ((edge < 0) | (other != row))
    return dark


def plants_of(farm, rng):
    """Centres, radii and rows of ellipsoids along the rows; the highest reach the top."""
    plants = []
    for row in range(-25, 26):
        x = -8.0 + rng.uniform(0, 1)
        while x < 90:
            size, half = rng.uniform(.93, 1), .5 * farm.height_m * rng.uniform(.985, 1)
            plants.append((x, row * farm.spacing_m, half, .65 * size, farm.half_width_m * size, half, row))
            x += 0.95
    return plants


def ellipsoids(plants, shot, origin, d, lens):
    """First hit of every ray of a whole picture with plants and ground, as prisms() gives it."""
    f, right, down = (np.array(a) for a in axes(shot))
    matrix = matrix_of(lens)
    shape = (lens.height, lens.width)
    d = d.reshape(3, *shape)
    t = np.where(d[2] < -1e-6, origin[2] / np.maximum(-d[2], 1e-6), np.inf).astype(np.float32)
    edge = np.where(d[2] < -1e-6, -1, -2).astype(np.int16)
    row = np.zeros(shape, np.int16)
    normal = np.stack([np.zeros(shape), np.zeros(shape), np.ones(shape)]).astype(np.float32)
    for *centre, rx, ry, rz, number in plants:
        c, r = (np.array(centre) - origin).astype(np.float32), np.array([rx, ry, rz], np.float32)
        depth = c @ f
        if depth < .5:
            continue
        at, _ = cv2.projectPoints(np.array([[[c @ right, c @ down, depth]]]), np.zeros(3), np.zeros(3), matrix,
                                  np.array(lens.distortion, float))
        reach = 1.4 * lens.fx * r.max() / max(depth - r.max(), .3) + 4
        u0, v0 = np.maximum(at.ravel() - reach, 0).astype(int)
        u1, v1 = np.minimum(at.ravel() + reach, shape[::-1]).astype(int)
        if u1 <= u0 or v1 <= v0:
            continue
        box = (slice(v0, v1), slice(u0, u1))
        e, o = d[(slice(None),) + box] / r[:, None, None], -c / r
        a, b = (e * e).sum(0), np.tensordot(o, e, 1)
        root = b * b - a * (o @ o - 1)
        near = (-b - np.sqrt(np.maximum(root, 0))) / a
        hit = (root > 0) & (near > 0) & (near < t[box])
        t[box][hit], edge[box][hit], row[box][hit] = near[hit], 0, number
        n = (o[:, None] + near[hit] * e[:, hit]) / r[:, None]
        normal[(slice(None),) + box][:, hit] = n / np.sqrt((n * n).sum(0))
    return t.ravel(), edge.ravel(), row.ravel(), normal.reshape(3, -1)


def colours(t, edge, row, normal, d, origin, shade, farm, look, lens, levels):
    """Red, green, blue of every ray's hit. shade: the cross-section that throws the shadows."""
    far = np.minimum(t, np.float32(1e5))
    hit = origin[:, None] + far * d
    canopy = edge >= 0
    side = np.mod(hit[1] + .5 * farm.spacing_m, farm.spacing_m) - .5 * farm.spacing_m
    colour = np.where(canopy, look["canopy"][:, None], look["ground"][:, None])
    if look["strip"] is not None:
        colour = np.where((np.abs(side) > .28 * farm.spacing_m) & ~canopy, look["strip"][:, None], colour)
    if look["leaf"] or look["soil"]:
        along = np.where(canopy, np.arctan2(hit[2] - .5 * farm.height_m, side), hit[1])
        grain = texture(levels, hit[0] / look["cell"], along / look["cell"], far / (lens.fx * look["cell"]))
        colour = colour * np.clip(1 + np.where(canopy, look["leaf"], look["soil"]) * grain, .1, 2.5)
    if look["light"] == "camera":
        colour = colour * (.1 + .9 * np.clip(-(d * normal).sum(0) / np.sqrt((d * d).sum(0)), 0, 1))
    elif look["light"] != "none":
        direct = np.clip(look["sun"].astype(np.float32) @ normal, 0, 1)
        if look["light"] == "shadow":
            direct[in_shadow(shade, farm, hit[1], hit[2], edge, row, look["sun"])] = 0
        colour = colour * (look["ambient"] + (1 - look["ambient"]) * direct * 1.3)
    colour = np.clip(look["gain"] * colour, 0, 1)
    if look["haze_m"]:
        clear = np.exp(-far / look["haze_m"])
        colour = colour * clear + look["sky"][:, None] * (1 - clear)
    return np.where(edge == -2, look["sky"][:, None], colour).astype(np.float32)


def matrix_of(lens):
    return np.array([[lens.fx, 0, lens.cx], [0, lens.fy, lens.cy], [0, 0, 1]])


def rays(lens, u, v, shot):
    """Directions (not of unit length: 1 along the optical axis) of pixels."""
    matrix = matrix_of(lens)
    px = np.stack([u, v], 1).astype(np.float64)
    at = (px - matrix[:2, 2]) / matrix.diagonal()[:2]
    if any(lens.distortion):
        at = cv2.undistortPointsIter(px[:, None], matrix, np.array(lens.distortion), None, None,
                                     (cv2.TERM_CRITERIA_COUNT, 12, 0))[:, 0]
    x, y = at.T
    return np.stack([f + x * r + y * d for f, r, d in zip(*axes(shot))]).astype(np.float32)


def picture(shot, farm, corners, plants, look, lens, levels):
    """One picture, blue, green, red in 0 to 255. With antialiasing pixels where two surfaces meet are the mean of four
    rays; ellipsoids are drawn twice as large and averaged."""
    scale = 2 if plants and look["antialias"] else 1
    big = Lens(lens.width * scale, lens.height * scale, lens.fx * scale, lens.fy * scale, (lens.cx + .5) * scale - .5,
               (lens.cy + .5) * scale - .5, lens.distortion)
    v, u = (a.ravel() for a in np.mgrid[0:big.height, 0:big.width])
    origin = np.array([shot[k] for k in "xyz"], np.float32)
    def cast(u, v):
        d = rays(big, u, v, shot)
        hit = ellipsoids(plants, shot, origin, d, big) if plants else prisms(corners, farm, origin, d)
        return colours(*hit, d, origin, corners, farm, look, big, levels), hit
    colour, (_, edge, row, _) = cast(u, v)
    if scale > 1:
        colour = cv2.resize(np.moveaxis(colour.reshape(3, big.height, big.width), 0, 2), (lens.width, lens.height),
                            interpolation=cv2.INTER_AREA).reshape(-1, 3).T
    elif look["antialias"]:
        surface = (edge.astype(np.float32) + 100 * row).reshape(big.height, big.width)
        box = np.ones((3, 3))
        border = (cv2.dilate(surface, box) != cv2.erode(surface, box)).ravel()
        near = [cast(u[border] + a, v[border] + b)[0] for a in (-.25, .25) for b in (-.25, .25)]
        colour[:, border] = sum(near) / 4
    return 255 * np.moveaxis(colour.reshape(3, lens.height, lens.width), 0, 2)[:, :, ::-1]


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("out")
    for name, choices in (("shape", SHAPES), ("look", LOOKS), ("flight", sorted(FLIGHTS))):
        p.add_argument("--" + name, default=choices[0], choices=choices)
    p.add_argument("--seed", type=int, default=1)
    p.add_argument("--shots", type=int, default=12, help="per leg")
    args = p.parse_args()
    rng = random.Random("%s %s %d" % (args.shape, args.look, args.seed))
    farm = Farm(round(rng.uniform(2.0, 3.2), 2), round(rng.uniform(.3, .7), 2), round(rng.uniform(1.2, 2.0), 2))
    look = draw_look(rng, args.look)
    bottom = rng.choice([0.0, 0.0, 0.5])
    lens = Lens()
    if rng.random() < .5:
        lens.distortion = (rng.uniform(-.15, .1), rng.uniform(-.08, .08), rng.gauss(0, .001), rng.gauss(0, .001),
                           rng.uniform(-.02, .02))
    plants = plants_of(farm, rng) if args.shape == "bushes" else []
    corners = cross_section(args.shape, farm, bottom)
    rng = random.Random("%s %s %s %d" % (args.shape, args.look, args.flight, args.seed))
    shots = shots_of(args.flight, args.shots, rng)
    suffix, quality = ("jpg", [cv2.IMWRITE_JPEG_QUALITY, look["quality"]]) if look["quality"] else ("png", [])
    os.makedirs(os.path.join(args.out, "frames"), exist_ok=True)
    write_truth(args.out, shots, farm, suffix)
    write_project(args.out, "solids-%s-%s-%s-%d" % (args.shape, args.look, args.flight, args.seed), farm, lens, suffix)
    write_log(args.out, shots, rng, farm)
    readme = "shape %s, bottom %g\n%s\n%s\n%s\n" % (args.shape, bottom, farm, lens, look)
    open(os.path.join(args.out, "README.txt"), "w").write(readme)
    levels = noise_levels(args.seed)
    for i, shot in enumerate(shots):
        image = picture(shot, farm, corners, plants, look, lens, levels)
        image = image + np.random.default_rng(1000 * args.seed + i).normal(0, look["noise"], image.shape)
        image = np.clip(np.rint(image), 0, 255).astype(np.uint8)
        cv2.imwrite(os.path.join(args.out, "frames", "shot-%04d.%s" % (i + 1, suffix)), image, quality)


if __name__ == "__main__":
    main()
