"""Pictures of what is measured: clouds, mesh, error and layers, made as users make them."""

import io
import subprocess
from pathlib import Path
from typing import List, Sequence

import numpy as np
from mesh_msgs_hdf5.files.save import save_file
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Mesh
from mesh_msgs_hdf5.rendering.render_camera import VIEWS, look_at

from mesh_tools_test.base.server_start import executable
from mesh_tools_test.reconstruction.scene import Scene

LAYERS = {  # and the limits of their colors
    "height_diff": "0,0.185",
    "roughness": "0,0.3",
    "steepness": "0,0.3",
    "border": "0,1",
    "inflation": "0,1",
}
_VIEW = "iso"
_SIZE, _DPI = (1200, 900), 100


def write_pictures(scene: Scene, folder: Path, layers: Sequence[str] = tuple(LAYERS)) -> List[Path]:
    """The maps truth.h5 and map.h5, and pictures of them and of layers, over what is there.

    Raises:
        RuntimeError: a verb of mesh_tool fails.
    """
    folder.mkdir(parents=True, exist_ok=True)
    truth, found = folder / "truth.h5", folder / "map.h5"
    world = scene.world
    mesh = Mesh(vertices=world.mesh.vertices, faces=world.mesh.faces, vertex_colors=world.colors)
    MapFile.write(str(truth), mesh, overwrite=True)
    MapFile.write(str(found), scene.mesh, overwrite=True)
    made = [folder / "clouds.png", folder / "truth.png", folder / "mesh.png", folder / "error.png"]
    _draw_clouds(scene, made[0])
    for path, picture, title in ((truth, made[1], "truth"), (found, made[2], "reconstruction")):
        _tool("render", path, picture, "--colors", "--view", _VIEW, "--title", title, "--force")
    _tool("compare", truth, found, "--picture", made[3], "--view", _VIEW, "--force")
    _tool("layers", "compute", found, *layers)
    for layer in layers:
        made.append(folder / ("layer_%s.png" % layer))
        where = ("--layer", layer, "--limits", LAYERS[layer], "--view", _VIEW)
        _tool("render", found, made[-1], *where, "--force")
    return made


def _tool(*words: object) -> None:
    command = [executable("mesh_msgs_hdf5", "mesh_tool"), *map(str, words), "--quiet"]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False)
    if done.returncode != 0:
        errors = done.stderr.decode(errors="replace").strip()
        raise RuntimeError("%s: %s" % (" ".join(command), errors))


def _draw_clouds(scene: Scene, path: Path) -> None:
    """All points in their colors, what is in front over what is behind; the drive in pink."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    points = np.concatenate([scan.in_map() for scan in scene.scans])
    colors = np.concatenate([scan.colors for scan in scene.scans if scan.colors is not None])
    camera = look_at(points, VIEWS[_VIEW], *_SIZE)
    seen = camera.screen(points)
    order = np.argsort(-seen[:, 2], kind="stable")
    column, row = np.floor(seen[order, :2]).astype(int).T
    picture = np.full((camera.height, camera.width, 3), 255, np.uint8)
    picture[row, column] = colors[order]
    figure = Figure(figsize=(_SIZE[0] / _DPI, _SIZE[1] / _DPI), dpi=_DPI)
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_axes([0.0, 0.0, 1.0, 0.95])
    axes.imshow(picture, interpolation="nearest")
    drive = camera.screen(scene.world.sensor.positions)
    axes.plot(drive[:, 0], drive[:, 1], color="deeppink", linewidth=1.0)
    axes.set_axis_off()
    text = "%d scans, %.2f M points, noise %g mm; pink: the sensor"
    axes.set_title(text % (len(scene.scans), scene.points, 1e3 * scene.lidar.noise), fontsize=11)
    out = io.BytesIO()
    canvas.print_png(out)
    save_file(str(path), out.getvalue(), overwrite=True)
