"""What every witness scene has besides pictures: the flights, and truth, log, camera and project as Furrow reads them."""
import dataclasses, math, os

FEET, LOG_HZ = 3.28084, 10


@dataclasses.dataclass
class Farm:
    """Rows along x through y = k spacing_m, and what is called their half width and top."""
    spacing_m: float
    half_width_m: float
    height_m: float


@dataclasses.dataclass
class Lens:
    """OpenCV's camera: k1, k2, p1, p2, k3 on the unit plane, (0, 0) the centre of the top-left pixel."""
    width: int = 1280
    height: int = 720
    fx: float = 874.33
    fy: float = 872.39
    cx: float = 640.49
    cy: float = 360.81
    distortion: tuple = (0, 0, 0, 0, 0)


FLIGHTS = {  # legs of (height above ground at start and end, pitch)
    "345": [(3, 3, -12.4), (4, 4, -13.8), (5, 5, -13.8)],
    "climb": [(3, 6, -20)],
    "oblique8": [(8, 8, -45)],
    "nadir30": [(30, 30, -90)],
}


def shots_of(flight, count, rng):
    """Poses with a slow wander; 1 m between shots along the rows, at most 40 m of them."""
    shots = []
    legs = FLIGHTS[flight]
    phase = [rng.uniform(0, 6.28) for _ in range(10)]
    def wave(i, k, sigma):
        return sigma * (math.sin(0.9 * i + phase[k]) + math.sin(0.37 * i + phase[k + 1]))
    total = count * len(legs)
    for leg, (h0, h1, pitch) in enumerate(legs):
        for s in range(count):
            i = leg * count + s
            f = s / max(1, count - 1)
            tilt = wave(i, 6, .15)
            shots.append(dict(x=i * min(1.0, 40.0 / total), y=wave(i, 0, .16), z=h0 + f * (h1 - h0) + wave(i, 2, .05),
                              yaw=wave(i, 4, 1.5), roll=wave(i, 8, .4),
                              pitch=pitch + tilt if pitch > -89 else -90.0 + abs(tilt)))
    return shots


def cross(a, b):
    return (a[1]*b[2]-a[2]*b[1], a[2]*b[0]-a[0]*b[2], a[0]*b[1]-a[1]*b[0])


def axes(shot):
    """Forward, right and down of the camera in the world."""
    y, p, r = (math.radians(shot[k]) for k in ("yaw", "pitch", "roll"))
    f = (math.cos(p) * math.cos(y), math.cos(p) * math.sin(y), math.sin(p))
    left0 = (-math.sin(y), math.cos(y), 0.0)
    up0 = cross(f, left0)
    left = tuple(math.cos(r) * a + math.sin(r) * b for a, b in zip(left0, up0))
    up = tuple(-math.sin(r) * a + math.cos(r) * b for a, b in zip(left0, up0))
    return f, tuple(-a for a in left), tuple(-a for a in up)


def write_log(out, shots, rng, farm):
    """AirData's columns, 10 rows a second, a shot every two: logged pitch is the true one + 0.7 deg, logged roll the
    true one - 0.3 deg, the barometer drifts by 0.5 m, the downward sensor sees leaves half of the time."""
    names = ["time(millisecond)", "datetime(utc)", "latitude", "longitude", "height_above_takeoff(feet)",
             "altitude_above_seaLevel(feet)", "height_sonar(feet)", "speed(mph)", "satellites", "gpslevel",
             " compass_heading(degrees)", " pitch(degrees)", " roll(degrees)", "isPhoto", "isVideo",
             "gimbal_heading(degrees)", "gimbal_pitch(degrees)", "gimbal_roll(degrees)", "flycState", "message"]
    start_s, step_s = 2.0, 2.0
    lines, gust = [",".join(names)], 0.0
    count = int((len(shots) - 1) * step_s * LOG_HZ) + 40
    for i in range(count):
        t = i / LOG_HZ
        at = min(max((t - start_s) / step_s, 0), len(shots) - 1)
        k = min(int(at), max(0, len(shots) - 2))
        a, b = shots[k], shots[min(k + 1, len(shots) - 1)]
        v = {c: a[c] + (at - k) * (b[c] - a[c]) for c in a}
        gust = 0.97 * gust + math.sqrt(1 - 0.97 ** 2) * rng.gauss(0, .1)
        height = round((v["z"] + 0.5 * i / count + gust) * 10) / 10
        sonar = round(min(v["z"] - (farm.height_m if rng.random() < .5 else 0) + rng.gauss(0, .03), 10) * 10) / 10
        is_shot = t >= start_s and abs(at - round(at)) < 1e-6 and at * step_s + start_s >= t - 1e-6
        second = 10 + int(t)
        lines.append(",".join([
            str(int(1000 * t)), "2024-06-18 08:%02d:%02d" % (41 + second // 60, second % 60),
            "%.9f" % (38.35 + (v["x"] + rng.gauss(0, .1)) / 111000.0),
            "%.9f" % (28.51 - (v["y"] + rng.gauss(0, .1)) / (111320.0 * math.cos(math.radians(38.35)))),
            "%.4f" % (height * FEET), "%.4f" % ((height + 190) * FEET), "%.4f" % (sonar * FEET), "1.1", "17", "5",
            "%.1f" % (-v["yaw"] % 360), "0.3", "0.2", str(int(is_shot)), "0", "%.1f" % (-v["yaw"] % 360),
            "%.1f" % (v["pitch"] + 0.7 + rng.gauss(0, .1)), "%.1f" % (v["roll"] - 0.3 + rng.gauss(0, .1)),
            "P-GPS", ""]))
    open(os.path.join(out, "airdata.csv"), "w").write("\n".join(lines) + "\n")


def write_truth(out, shots, farm, suffix="jpg"):
    rows = ["shot_id,image,height_above_ground_m,height_above_canopy_m,pitch_deg,roll_deg,yaw_deg,cross_track_m,"
            "nearest_row,row_spacing_m,half_width_m,row_height_m"]
    for i, s in enumerate(shots, 1):
        rows.append("shot-%04d,frames/shot-%04d.%s,%.5f,%.5f,%.5f,%.5f,%.5f,%.5f,0,%g,%g,%g"
                    % (i, i, suffix, s["z"], s["z"] - farm.height_m, s["pitch"], s["roll"], s["yaw"], s["y"],
                       farm.spacing_m, farm.half_width_m, farm.height_m))
    open(os.path.join(out, "truth.csv"), "w").write("\n".join(rows) + "\n")


def write_project(out, name, farm, lens, suffix="jpg"):
    matrix = "!!opencv-matrix\n   rows: %d\n   cols: %d\n   dt: d\n   data: [ %s ]\n"
    open(os.path.join(out, "camera_true.yaml"), "w").write(
        "%YAML:1.0\n---\n" + "image_width: %d\nimage_height: %d\ncamera_matrix: " % (lens.width, lens.height)
        + matrix % (3, 3, "%g, 0, %g, 0, %g, %g, 0, 0, 1" % (lens.fx, lens.cx, lens.fy, lens.cy))
        + "distortion_model: plumb_bob\ndistortion_coefficients: "
        + matrix % (5, 1, ", ".join("%g" % d for d in lens.distortion)))
    open(os.path.join(out, "project.yaml"), "w").write(
        "name: %s\ncamera: { model: camera_true.yaml }\nshots: { images: frames/*.%s }\n"
        "telemetry: { file: airdata.csv }\n"
        "rows: { spacing_m: %g, spacing_sigma_m: %g, half_width_m: %g, height_m: %g }\n"
        % (name, suffix, farm.spacing_m, 0.01 * farm.spacing_m, farm.half_width_m, farm.height_m))
