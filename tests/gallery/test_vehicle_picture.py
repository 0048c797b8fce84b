"""Picture of the vehicle: what is drawn over it is where Drake renders it."""

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from aerodrake.gallery.camera import Camera
from aerodrake.gallery.vehicle_picture import VehiclePicture
from aerodrake.model.vehicle.robot import TOOL_FRAME
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Scenario

CAMERA = Camera(np.array([0.8, 1.5, 1.7]), np.array([-0.1, 0.1, 1.3]), 200, 120, 0.6)


def test_marks_are_where_the_world_is_rendered():
    vehicle = VehicleModel.load(Scenario())
    point = np.array([-0.5, 0.4, 1.25])
    picture = VehiclePicture(vehicle, point + 0.004 * np.eye(3), CAMERA)
    assert set(picture.frames) == {TOOL_FRAME, *vehicle.joint_names}
    assert picture.frames[TOOL_FRAME].translation() == pytest.approx(vehicle.p_E)
    canvas = FigureCanvasAgg(picture.figure)
    canvas.draw()
    x, y = CAMERA.project(point)[0].round().astype(int)
    near = np.asarray(canvas.buffer_rgba())[y - 3 : y + 4, x - 3 : x + 4, :3].astype(int)
    assert (near[..., 0] - near[..., 2] > 60).any(), "the orange path"
    picture.frame(picture.frames[TOOL_FRAME])
    picture.box(vehicle.p_E, np.full(3, 0.1), "#1864ab")
    picture.name("tool", vehicle.p_E, (10, 10))
    picture.write("tool", vehicle.p_E, (0, 5))
    canvas.draw()
