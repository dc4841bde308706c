"""Renders a flight over a vineyard with Blender's Cycles, as somebody who models a vineyard to judge heights would.

Rows are cards of leaves in a cross-section, or hedges of one lumpy mesh, over trunks and posts, in sun and sky; the
top is the height that the cross-section was given. The seed draws sizes, colours, sun, sky, lens and tone curve.
Nothing is shared with Furrow's simulator. Needs Debian's blender and python3-opencv; 10 to 25 s a picture on two cores.

    blender -b --factory-startup -P tests/witness/blender_vineyard.py -- OUT --shape v --strip blades --seed 1
    furrow run OUT --truth OUT/truth.csv --out out/witness
"""
import argparse, math, os, random, sys
import bpy, cv2
import numpy as np
from mathutils import Matrix, Vector
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from flight import FLIGHTS, Farm, Lens, axes, shots_of, write_log, write_project, write_truth

SEGMENT, VARIANTS = 2.0, 8        # m of row in one mesh, and how many of them differ
ROWS, X_START, X_END = 24, -6, 110  # rows on either side, and where they begin and end, m
SHAPES = ["box", "v", "round", "ellipse", "hedge"]
STRIPS = ["none", "texture", "blades"]


def half_width_at(shape, farm, bottom, z):
    """Half width of the cross-section at height z, bottom <= z <= top."""
    up, w = (z - bottom) / (farm.height_m - bottom), farm.half_width_m
    if shape == "v":
        return w * (.35 + .65 * up)
    if shape == "ellipse":
        return w * math.sqrt(max(0.0, 1 - (2 * up - 1) ** 2))
    shoulder = 0.6 * w if shape == "round" else 0.0
    below = max(0.0, z - (farm.height_m - shoulder))
    return w if below <= 0 else w * (.4 + .6 * math.sqrt(max(0.0, 1 - (below / shoulder) ** 2)))


def add_tube(vertices, faces, x, y, radius, z0, z1):
    base = len(vertices)
    for z in (z0, z1):
        vertices += [(x + radius * math.cos(a), y + radius * math.sin(a), z) for a in np.arange(6) * math.pi / 3]
    faces += [(base + k, base + (k + 1) % 6, base + 6 + (k + 1) % 6, base + 6 + k) for k in range(6)]


def leaf(centre, normal, size, rng):
    """Corners of a card of two folded halves."""
    n = Vector(normal).normalized()
    a = n.cross(Vector([rng.gauss(0, 1) for _ in range(3)])).normalized()
    b, c, fold = n.cross(a), Vector(centre), .25 * size * n
    return [c - .5 * size * a, c + .45 * size * b + .5 * fold, c + .6 * size * a, c - .45 * size * b + .5 * fold]


def leaves(shape, farm, bottom, look, rng):
    """A segment of foliage: leaves whose middles lie in the cross-section, most of them near its surface."""
    vertices, faces = [], []
    thick = rng.gauss(1, look["uneven"])  # one plant is wider than the next
    while len(faces) < look["leaves"] * SEGMENT:
        z = rng.uniform(bottom, farm.height_m)
        w = half_width_at(shape, farm, bottom, z)
        if rng.uniform(0, farm.half_width_m) > w:
            continue
        y = rng.uniform(-w, w)
        inner = abs(y) < w - .2 and z < farm.height_m - .2
        if inner and rng.random() < .8:
            continue
        out = (rng.gauss(0, .5), math.copysign(.6 * abs(y) / max(w, .05), y) + rng.gauss(0, .4), .5 + rng.gauss(0, .4))
        vertices += leaf((rng.uniform(0, SEGMENT), y * thick, z), out, look["leaf_m"] * rng.uniform(.7, 1.2), rng)
        faces.append(tuple(range(len(vertices) - 4, len(vertices))))
    for _ in range(int(look["shoots"] * SEGMENT)):  # tips that stand over the top
        x, y = rng.uniform(0, SEGMENT), rng.uniform(-.7, .7) * half_width_at(shape, farm, bottom, farm.height_m - .05)
        lean, reach = rng.gauss(0, .3), rng.uniform(.05, .25)
        for f in np.arange(0, 1, .2):
            vertices += leaf((x, y + lean * f * reach, farm.height_m + f * reach), [rng.gauss(0, 1) for _ in range(3)],
                             .6 * look["leaf_m"], rng)
            faces.append(tuple(range(len(vertices) - 4, len(vertices))))
    return vertices, faces


def hedge(farm, bottom, look, rng):
    """A segment of a trimmed hedge: a rounded box of one mesh, its points moved in and out by noise."""
    w, r, top = farm.half_width_m, .25 * farm.half_width_m, farm.height_m
    arc = [(w - r + r * math.cos(a), top - r + r * math.sin(a)) for a in np.linspace(0, math.pi / 2, 6)]
    right = [(w, z) for z in np.arange(bottom, top - r, .04)] + arc
    flat = [(y, top) for y in np.arange(w - r - .04, -(w - r), -.04)]
    outline = right + flat + [(-y, z) for y, z in reversed(right)]
    count = int(SEGMENT / .04) + 1
    bumps = cv2.resize(np.random.default_rng(rng.randrange(1 << 30)).standard_normal((count // 2, len(outline) // 2)),
                       (len(outline), count), interpolation=cv2.INTER_CUBIC) * look["lumps_m"]
    vertices, faces, n = [], [], len(outline)
    for i in range(count):
        for j, (y, z) in enumerate(outline):
            scale = 1 + bumps[i % (count - 1), j] / math.hypot(y, z - bottom + .3)
            vertices.append((i * SEGMENT / (count - 1), y * scale, bottom - .3 + (z - bottom + .3) * scale))
    for i in range(count - 1):
        faces += [(i * n + j, i * n + j + 1, (i + 1) * n + j + 1, (i + 1) * n + j) for j in range(n - 1)]
    return vertices, faces


def blades(width, height, rng):
    vertices, faces = [], []
    for _ in range(int(900 * width * SEGMENT)):
        x, y, a = rng.uniform(0, SEGMENT), rng.uniform(-.5, .5) * width, rng.uniform(0, 6.28)
        h, thin = height * rng.uniform(.5, 1.3), rng.uniform(.004, .01)
        c, s = thin * math.cos(a), thin * math.sin(a)
        vertices += [(x - c, y - s, 0), (x + c, y + s, 0), (x + rng.gauss(0, .5) * h, y + rng.gauss(0, .5) * h, h)]
        faces.append(tuple(range(len(vertices) - 3, len(vertices))))
    return vertices, faces


def material(name, dark, light, grain_m=0.0, translucent=0.0):
    """Matt, between two colours: by noise of a grain, or by chance from leaf to leaf."""
    m = bpy.data.materials.new(name)
    m.use_nodes = True
    nodes, link = m.node_tree.nodes, m.node_tree.links.new
    nodes.clear()
    geometry, ramp = nodes.new("ShaderNodeNewGeometry"), nodes.new("ShaderNodeValToRGB")
    for element, colour, at in zip(ramp.color_ramp.elements, (dark, light), (.3, .7) if grain_m else (0, 1)):
        element.color, element.position = (*colour, 1), at
    if grain_m:
        noise = nodes.new("ShaderNodeTexNoise")
        noise.inputs["Scale"].default_value, noise.inputs["Detail"].default_value = .5 / grain_m, 5
        link(geometry.outputs["Position"], noise.inputs["Vector"])
        link(noise.outputs["Fac"], ramp.inputs["Fac"])
    else:
        link(geometry.outputs["Random Per Island"], ramp.inputs["Fac"])
    diffuse, through, mix = (nodes.new("ShaderNode" + n) for n in ("BsdfDiffuse", "BsdfTranslucent", "MixShader"))
    for shader in (diffuse, through):
        link(ramp.outputs["Color"], shader.inputs["Color"])
    mix.inputs[0].default_value = translucent
    link(diffuse.outputs[0], mix.inputs[1])
    link(through.outputs[0], mix.inputs[2])
    link(mix.outputs[0], nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return m


def mesh(name, parts):
    """A mesh of (vertices, faces, material) parts."""
    data, vertices, faces, index = bpy.data.meshes.new(name), [], [], []
    for k, (v, f, look) in enumerate(parts):
        data.materials.append(look)
        faces += [tuple(i + len(vertices) for i in face) for face in f]
        index += [k] * len(f)
        vertices += v
    data.from_pydata(vertices, [], faces)
    data.polygons.foreach_set("material_index", index)
    data.update()
    return data


def place(data, x, y, z=0.0, turn=False):
    """An instance; turned about its own middle it shows its other side."""
    o = bpy.data.objects.new(data.name, data)
    o.location, o.rotation_euler = (x + (SEGMENT if turn else 0), y, z), (0, 0, math.pi if turn else 0)
    bpy.context.scene.collection.objects.link(o)


def draw_look(rng, strip):
    """Everything that is not the cross-section."""
    def shades(colour, spread):
        f = rng.uniform(.85, 1.2)
        return [tuple(f * k * c for c in colour) for k in (1 - spread, 1 + spread)]
    soil = rng.choice([(.30, .20, .12), (.20, .14, .09), (.38, .30, .21), (.26, .13, .07)])
    leaf = rng.choice([(.07, .16, .03), (.10, .20, .04), (.06, .13, .04)])
    if strip != "none":
        leaf = rng.choice([leaf, (.11, .15, .05), (.08, .11, .05)])  # duller than grass
    grass = rng.choice([(.10, .24, .03), (.14, .26, .04), (.16, .21, .06)])
    return dict(soil=shades(soil, .25), leaf=shades(leaf, .35), grass=shades(grass, .3), grain_m=rng.choice([.05, .1, .25]),
                leaf_m=rng.uniform(.09, .14), leaves=rng.choice([500, 700, 900]), uneven=rng.choice([.02, .06]),
                shoots=rng.choice([0, 0, 4]), lumps_m=rng.uniform(.02, .05), strip_width=rng.uniform(.35, .6),
                grass_m=rng.uniform(.05, .15), elevation=rng.uniform(25, 65), azimuth=rng.uniform(0, 360),
                sun=rng.uniform(2.5, 4.5), sky=rng.uniform(.6, 1.1), curve=rng.choice(["Filmic", "Standard"]))


def grow(shape, strip, farm, bottom, look, rng):
    """Puts rows, posts and alleys into the scene."""
    green = material("leaf", *look["leaf"], .04 if shape == "hedge" else 0, 0 if shape == "hedge" else .3)
    wood, post = material("wood", (.06, .04, .03), (.12, .09, .06), .05), material("post", (.25, .24, .22), (.4, .4, .38), .1)
    soil, turf = material("soil", *look["soil"], look["grain_m"]), material("grass", *look["grass"], .12)
    side = 2000.0
    place(mesh("soil", [([(-side, -side, 0), (side, -side, 0), (side, side, 0), (-side, side, 0)], [(0, 1, 2, 3)], soil)]), 0, 0)
    segments = []
    for k in range(VARIANTS):
        foliage = hedge(farm, bottom, look, rng) if shape == "hedge" else leaves(shape, farm, bottom, look, rng)
        trunks = ([], [])
        for x in (.5, 1.5):
            add_tube(*trunks, x + rng.gauss(0, .05), rng.gauss(0, .02), .03, 0, bottom + .25)
        segments.append(mesh("row%d" % k, [(*foliage, green), (*trunks, wood)]))
    stake = ([], [])
    add_tube(*stake, 0, 0, .04, 0, farm.height_m - .05)
    stake = mesh("post", [(*stake, post)])
    for row in range(-ROWS, ROWS + 1):
        for x in np.arange(X_START, X_END, SEGMENT):
            place(rng.choice(segments), x, row * farm.spacing_m + rng.gauss(0, .01), 0, rng.random() < .5)
        for x in range(X_START, X_END, 6):
            place(stake, x, row * farm.spacing_m)
    if strip == "none":
        return
    width = look["strip_width"] * farm.spacing_m
    edge = [(x, (s * .5 + rng.gauss(0, .015)) * width, 0) for s in (-1, 1) for x in np.arange(X_START, X_END + 1, .5)]
    n = len(edge) // 2
    carpet = mesh("strip", [(edge, [(i, i + 1, n + i + 1, n + i) for i in range(n - 1)], turf)])
    tufts = [mesh("tufts%d" % k, [(*blades(width, look["grass_m"], rng), material("blade", *look["grass"], 0, .3))])
             for k in range(4)] if strip == "blades" else []
    for row in range(-ROWS, ROWS):
        y = (row + .5) * farm.spacing_m
        place(carpet, 0, y, .004)
        for x in np.arange(X_START, 50, SEGMENT) if tufts and abs(row) < 9 else []:
            place(rng.choice(tufts), x, y, 0, rng.random() < .5)


def light(look):
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    sun.data.energy, sun.data.angle, sun.data.color = look["sun"], .0093, (1, .96, .88)
    sun.rotation_euler = (0, math.radians(90 - look["elevation"]), math.radians(look["azimuth"]))
    bpy.context.scene.collection.objects.link(sun)
    world = bpy.context.scene.world = bpy.data.worlds.new("sky")
    world.use_nodes = True
    nodes, link = world.node_tree.nodes, world.node_tree.links.new
    at, axis, ramp = (nodes.new("ShaderNode" + n) for n in ("TexCoord", "SeparateXYZ", "ValToRGB"))
    ramp.color_ramp.elements[0].color = (.75, .8, .88, 1)
    ramp.color_ramp.elements[1].color = (.25, .42, .8, 1)
    link(at.outputs["Generated"], axis.inputs[0])
    link(axis.outputs["Z"], ramp.inputs["Fac"])
    link(ramp.outputs["Color"], nodes["Background"].inputs["Color"])
    nodes["Background"].inputs["Strength"].default_value = look["sky"]


def lens_map(lens):
    """Size of the pinhole picture, focal length fx, that holds all that the lens sees, and where each pixel lies in it."""
    v, u = np.mgrid[0:lens.height, 0:lens.width].astype(np.float64)
    matrix = np.array([[lens.fx, 0, lens.cx], [0, lens.fy, lens.cy], [0, 0, 1]])
    at = cv2.undistortPointsIter(np.stack([u.ravel(), v.ravel()], 1)[:, None], matrix, np.array(lens.distortion, float),
                                 None, None, (cv2.TERM_CRITERIA_COUNT, 12, 0))[:, 0] * lens.fx
    width, height = (2 * (int(np.abs(at[:, k]).max()) + 4) for k in (0, 1))
    x, y = (a.reshape(u.shape).astype(np.float32) for a in (at + [(width - 1) / 2, (height - 1) / 2]).T)
    return (width, height), (x, y)


def set_up(lens, size, samples, threads, curve):
    scene = bpy.context.scene
    render, cycles = scene.render, scene.cycles
    render.engine, render.use_persistent_data = "CYCLES", True
    render.resolution_x, render.resolution_y, render.resolution_percentage = *size, 100
    render.threads_mode, render.threads = "FIXED", threads
    render.image_settings.file_format = "PNG"
    scene.view_settings.view_transform = curve
    cycles.samples, cycles.use_denoising, cycles.adaptive_threshold = samples, False, .03
    cycles.max_bounces, cycles.diffuse_bounces, cycles.transmission_bounces = 2, 1, 1
    scene.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.collection.objects.link(scene.camera)
    data = scene.camera.data
    data.sensor_fit, data.sensor_width, data.lens = "HORIZONTAL", 36, 36 * lens.fx / size[0]
    data.clip_start, data.clip_end = .05, 5000


def aim(shot):
    f, right, down = (Vector(a) for a in axes(shot))
    m = Matrix((right, -down, -f)).transposed().to_4x4()
    m.translation = [shot[k] for k in "xyz"]
    bpy.context.scene.camera.matrix_world = m


def main():
    p = argparse.ArgumentParser(prog="blender_vineyard.py", description=__doc__,
                                formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("out")
    for name, choices in (("shape", SHAPES), ("strip", STRIPS), ("flight", sorted(FLIGHTS))):
        p.add_argument("--" + name, default=choices[0], choices=choices)
    p.add_argument("--seed", type=int, default=1)
    p.add_argument("--shots", type=int, default=12, help="per leg")
    p.add_argument("--samples", type=int, default=24, help="per pixel")
    p.add_argument("--threads", type=int, default=2)
    args = p.parse_args(sys.argv[sys.argv.index("--") + 1:])
    rng = random.Random("%s %s %d" % (args.shape, args.strip, args.seed))
    farm = Farm(round(rng.uniform(2.0, 3.2), 2), round(rng.uniform(.2, .4), 2), round(rng.uniform(1.2, 2.0), 2))
    bottom = farm.height_m * rng.uniform(.3, .45)
    look = draw_look(rng, args.strip)
    lens = Lens(fx=rng.uniform(870, 900))
    lens.fy = lens.fx
    if rng.random() < .5:
        lens.distortion = (rng.uniform(-.08, .04), rng.uniform(-.03, .03), rng.gauss(0, .0005), rng.gauss(0, .0005), 0)
    shots = shots_of(args.flight, args.shots, random.Random("%s %d" % (args.flight, args.seed)))
    for d in ("work", "frames"):
        os.makedirs(os.path.join(args.out, d), exist_ok=True)
    write_truth(args.out, shots, farm)
    write_project(args.out, "blender-%s-%s-%s-%d" % (args.shape, args.strip, args.flight, args.seed), farm, lens)
    write_log(args.out, shots, random.Random(args.seed), farm)
    open(os.path.join(args.out, "README.txt"), "w").write(
        "Blender, shape %s from %.2f m, strip %s\n%s\n%s\n%s\n" % (args.shape, bottom, args.strip, farm, lens, look))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    grow(args.shape, args.strip, farm, bottom, look, rng)
    light(look)
    size, (x, y) = lens_map(lens)
    set_up(lens, size, args.samples, args.threads, look["curve"])
    for i, shot in enumerate(shots, 1):
        name = os.path.join(args.out, "frames", "shot-%04d.jpg" % i)
        if os.path.exists(name):
            continue
        aim(shot)
        bpy.context.scene.render.filepath = pinhole = os.path.join(args.out, "work", "shot.png")
        bpy.ops.render.render(write_still=True)
        cv2.imwrite(name, cv2.remap(cv2.imread(pinhole), x, y, cv2.INTER_CUBIC), [cv2.IMWRITE_JPEG_QUALITY, 92])


main()
