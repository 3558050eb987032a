"""Takes pictures of RViz on a virtual screen."""
import os

import numpy as np
from osmesa_harness.back_ends import BackEnd, environment_of
from PIL import Image

from mesh_tools_test.demo import isolines, key, navigation_node, robot_model
from mesh_tools_test.demo.orbit_camera import whole_map
from mesh_tools_test.demo.processes import process, subscribers, wait_until
from mesh_tools_test.demo.rviz_config import (
    BACKGROUND,
    ISOLINE,
    SERVER,
    VIEW,
    picture_config,
)
from mesh_tools_test.demo.screenshot import settled_picture, view_of

PLACES = "start", "goal"


class Photographer:
    """Takes pictures of the whole map, all from the same place."""

    def __init__(self, stack, output, uri, server, made):
        """
        :param uri: of the master
        :param server: (name, process, log file)
        :param made: a pipeline.Prepared
        """
        self._screen = stack.enter_context(environment_of(BackEnd.OSMESA_X, os.environ))
        self._logs, self._output = output / "logs", output
        self._uri, self._server, self._map = uri, server, made.mesh_map
        self._places = dict(zip(PLACES, (made.start, made.goal)))
        self._camera = whole_map(made.mesh_map.vertices, made.start, made.goal, VIEW)
        self._robot = robot_model.times(max(self._camera.meters([made.start, made.goal])))
        robot_model.describe(self._robot)

    def take(self, picture, limits, potential=None, driven=False):
        """RViz with one thing, as long as it takes to draw it; returns what to say of the picture.

        :param picture: a pictures.Picture
        :param limits: of its colors, in the unit of the layer
        :param potential: (V,) of which lines of equal cost are drawn
        :param driven: whether there is a track
        """
        handles, topics = [key.robot(self._robot)], []
        if picture.planner:
            handles.append(key.path(picture.planner))
            topics.append(f"{SERVER}/{picture.planner.name}/path")
        if picture.track and driven:
            handles.append(key.track(picture.planner))
        if potential is not None:
            handles.append(key.isoline(self._publish_isolines(potential, limits)))
            topics.append(isolines.TOPIC)
        view = self._view_of_rviz(picture, limits, topics)
        height, width = view.shape[:2]
        camera = self._camera._replace(size=(width, height))
        image = key.with_key(view, camera, picture.title, handles, self._places)
        image.save(self._output / picture.file)
        size = f"{image.width} x {image.height} pixels"
        return f"{picture.file}, {size}, drawn by OSMesa on a virtual screen"

    def _view_of_rviz(self, picture, limits, topics):
        """The 3D view (H, W, 3) of RViz, when it has drawn all."""
        config = self._logs / f"{picture.file}.rviz"
        frame = self._map.frame_id
        config.write_text(picture_config(picture, limits, self._camera, frame), encoding="utf-8")
        command = ["rviz", "--disable-anti-aliasing", "-d", str(config.resolve())]
        with process("rviz", command, self._logs, self._screen) as rviz:
            wait_until(
                lambda: all(subscribers(self._uri, topic) for topic in topics),
                60,
                "RViz's subscription of what a picture shows",
                [self._server, rviz],
            )
            window = np.asarray(settled_picture(self._screen, rviz))
        Image.fromarray(window).save(self._logs / picture.file)
        return view_of(window, BACKGROUND)

    def _publish_isolines(self, potential, limits):
        """Lines of equal cost for RViz; returns the difference between neighbors."""
        step = isolines.step(limits[1])
        segments, values = isolines.isolines(self._map.vertices, self._map.faces, potential, step)
        dark = values > np.mean(limits)  # what is far is dark
        pixel = self._camera.pixel
        marker = isolines.marker(
            segments, dark, self._map.frame_id, ISOLINE * pixel, 2 * ISOLINE * pixel
        )
        navigation_node.latch(isolines.TOPIC, marker)
        return step
