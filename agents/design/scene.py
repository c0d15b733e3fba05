"""The line in 3D in a browser: solids, reach, landings, names, and handles by which bins and robots are dragged."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, Final, final

import numpy as np
import viser

from pnt_gym.arrays import Floats
from pnt_gym.cells.conveyor.furniture import ABOVE
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.scene import belt_extent
from pnt_gym.palette import ITEMS

from ..line.plan_picture import arriving, spacing
from . import changes
from .answers import Answer
from .changes import Change
from .films import FIXED, Frame3D, Solids, Still
from .shapes import mesh, outlines

FLOOR: Final = (236, 238, 241)
REACH: Final = (76, 114, 176)
SHARES: Final = np.array([[214, 39, 40], [244, 182, 182], [60, 175, 95]], dtype=np.uint8)
"""Colours of places from which no bin, not every bin, and every bin is reached."""
LIFT: Final = 0.004
"""Height of the reach map over the belt [m]."""
SPARE: Final = 32
"""Solids for which a layer has room beyond those that it shows."""
HIDDEN: Final = 1e-6
"""Size of a solid that is not shown."""
NOTHING: Final = Solids(np.zeros((0, 3)), np.zeros((0, 4)), np.zeros((0, 3)), np.zeros((0, 4)))
"""No solids."""
GRIP: Final = 0.28
"""Size of the handles [m]."""
CLIPPED: Final = 0.25
"""Height over the belt above which the view from above shows nothing [m]."""
LOW: Final = 0.4
"""Height of the floor under the belt's surface [m]."""


@final
class Layer:
    """Solids of one shape that change, in one node of the scene.

    Args:
        scene: viser's scene.
        name: name of the node.
        shape: shape of the solids.
    """

    def __init__(self, scene: viser.SceneApi, name: str, shape: str) -> None:
        self._scene, self._name, self._shape = scene, name, shape
        self._node: Any = None
        self._room = 0

    def show(self, solids: Solids) -> None:
        """Show solids in place of those that were shown."""
        count = len(solids.position)
        if count > self._room or self._node is None:
            self._room = count + SPARE
            self._make(solids)
        else:
            for name, values in self._columns(solids).items():
                setattr(self._node, name, values)

    def _columns(self, solids: Solids) -> dict[str, Any]:
        """Columns of the node, filled up with solids that are not seen."""
        lack = self._room - len(solids.position)
        position = np.concatenate([solids.position, np.zeros((lack, 3))])
        wxyz = np.concatenate([solids.wxyz, np.tile([1.0, 0.0, 0.0, 0.0], (lack, 1))])
        half = np.concatenate([solids.half, np.full((lack, 3), HIDDEN)])
        colours = np.concatenate([solids.rgba[:, :3], np.ones((lack, 3))])
        return {
            "batched_positions": position.astype(np.float32),
            "batched_wxyzs": wxyz.astype(np.float32),
            "batched_scales": half.astype(np.float32),
            "batched_colors": (255.0 * colours).clip(0.0, 255.0).astype(np.uint8),
        }

    def _make(self, solids: Solids) -> None:
        vertices, faces = mesh(self._shape)
        opacity = float(solids.rgba[0, 3]) if len(solids.rgba) else 1.0
        self._node = self._scene.add_batched_meshes_simple(
            self._name,
            vertices,
            faces,
            **self._columns(solids),
            flat_shading=self._shape != "ball",
            opacity=None if opacity >= 1.0 else opacity,
            lod="off",
            side="double" if opacity < 1.0 else "front",
            cast_shadow=False,
        )


@final
class BeltScene:
    """A line in 3D, which is drawn anew where it has changed.

    Args:
        server: viser's server.
        drag: called with what was dragged, when the engineer lets go.
    """

    def __init__(self, server: viser.ViserServer, drag: Callable[[Change], object]) -> None:
        self._server, self._scene, self._drag = server, server.scene, drag
        self._layers = dict[str, Layer]()
        self._still: Still | None = None
        self._shown: LineConfig | None = None
        self._landed: Answer | None = None
        self._handles = dict[str, Any]()
        self._named = list[Any]()
        server.scene.set_up_direction("+z")
        server.scene.world_axes.visible = False
        server.scene.configure_default_lights(enabled=True, cast_shadow=False)
        self._root = self._scene.add_frame("/line", show_axes=False)

    def draw(self, line: LineConfig) -> None:
        """Draw a design, unless it looks like the one that is drawn."""
        if self._shown is not None and looks(self._shown) == looks(line):
            self.place_handles(line)
            return
        self._still, is_first = Still.of(line), self._shown is None
        self._shown = line
        with self._server.atomic():
            self._root.position = (self._still.origin, 0.0, 0.0)
            if is_first:
                self.look(line, self._server.initial_camera)
            self.rest()
            self._draw_layers(FIXED, split(self._still.fixed))
            low, high = belt_extent(line)
            place = ((low + high) / 2.0, 0.0, line.cell.belt.height - LOW)
            self._scene.add_box("/floor", FLOOR, (high - low + 1.0, 2.6, 0.01), position=place, cast_shadow=False)
            self._draw_reach(line, self._still)
            self._draw_names(line)
            self.place_handles(line)

    def rest(self) -> None:
        """Show the line as a shift begins."""
        if self._still is not None:
            self.show(self._still.moment)

    def show(self, moment: Frame3D) -> None:
        """Show a moment of a shift."""
        with self._server.atomic():
            for layer, solids in moment.items():
                self._draw_layers(layer, solids)

    def look(self, line: LineConfig, camera: Any, from_above: bool = False) -> None:
        """Turn a camera to the whole line, from the side of the bins or from above."""
        low, high = belt_extent(line)
        target = np.array([(low + high) / 2.0, 0.02, line.cell.belt.height])
        away = max(2.4, 0.7 * (high - low))
        way = np.array([0.0, -0.02, 1.0]) if from_above else np.array([-0.12, 0.74, 0.62])
        camera.position = target + 1.1 * away * way / np.linalg.norm(way)
        camera.look_at = target
        camera.up_direction = (0.0, 1.0, 0.0) if from_above else (0.0, 0.0, 1.0)
        # From above, what stands over the belt would hide the belt.
        camera.near = 1.1 * away - CLIPPED if from_above else 0.01

    def show_handles(self, are_shown: bool) -> None:
        """Show or hide all handles."""
        with self._server.atomic():
            for handle in self._handles.values():
                handle.visible = are_shown

    def landings(self, answer: Answer | None) -> None:
        """Show where the items of a judged design come down; None for none."""
        if answer is self._landed:
            return
        self._landed = answer
        self._scene.remove_by_name("/landings")
        if answer is None or answer.plan.counted is None:
            return
        points, colours = landing_cloud(answer)
        self._scene.add_point_cloud(
            "/landings", points.astype(np.float32), colours, point_size=0.02, point_shape="circle"
        )

    def _draw_layers(self, name: str, solids: Mapping[str, Solids]) -> None:
        """Draw the solids of a layer by shape; shapes of which it has none any more disappear."""
        drawn = {f"/line/{name}_{shape}" for shape in solids}
        for key in self._layers.keys() - drawn:
            if key.startswith(f"/line/{name}_"):
                self._layers[key].show(NOTHING)
        for shape, group in solids.items():
            key = f"/line/{name}_{shape}"
            if key not in self._layers:
                self._layers[key] = Layer(self._scene, key, shape.partition("_")[0])
            self._layers[key].show(group)

    def _draw_reach(self, line: LineConfig, still: Still) -> None:
        """Colour the windows by the share of bins that are reached from there, and draw the reach of the hands."""
        tiles, height, size = list[Floats](), line.cell.belt.height + LIFT, spacing(line)
        colours, borders = list[Any](), list[Floats]()
        for index, (robot, sheet) in enumerate(zip(line.robots, line.sheets(), strict=True)):
            reached = arriving(still.cell, index)
            borders.append(outlines(sheet.reach, robot.x, height))
            if not reached:
                continue
            count = np.sum([feasible for _, feasible in reached.values()], axis=0)
            places = next(iter(reached.values()))[0][:, :2] + [robot.x, 0.0]
            tiles.append(np.column_stack([places, np.full(len(places), height)]))
            colours.append(SHARES[np.where(count == 0, 0, np.where(count < len(reached), 1, 2))])
        position = np.concatenate([np.zeros((0, 3)), *tiles]) - [still.origin, 0.0, 0.0]
        rgba = np.column_stack([np.concatenate([np.zeros((0, 3)), *colours]) / 255.0, np.full(len(position), 0.75)])
        half = np.tile([*(0.48 * size), 0.001], (len(position), 1))
        wxyz = np.tile([1.0, 0.0, 0.0, 0.0], (len(position), 1))
        self._draw_layers("reach", {"box": Solids(position, wxyz, half, rgba)})
        points = np.concatenate(borders).astype(np.float32)
        self._scene.add_line_segments("/border", points, REACH, thickness=0.008)

    def _draw_names(self, line: LineConfig) -> None:
        """Write the names of robots and bins."""
        for node in self._named:
            node.remove()
        self._named.clear()
        high = line.cell.belt.height + 1.32 + ABOVE
        for index, robot in enumerate(line.robots):
            sheet = line.sheets()[index].name
            self._name(f"robot_{index}", f"{robot.name} ({sheet})", (robot.x, line.cell.belt.y[0] - 0.1, high))
            for number, bin_ in enumerate(robot.bins or line.cell.bins.fixed):
                place = (robot.x + bin_.x, bin_.y + bin_.size[1] / 2.0, line.cell.bins.rim)
                self._name(f"bin_{index}_{number}", bin_.name, place)

    def _name(self, key: str, text: str, place: tuple[float, float, float]) -> None:
        label = self._scene.add_label(f"/names/{key}", text, position=place, anchor="bottom-center")
        self._named.append(label)

    # Handles.

    def place_handles(self, line: LineConfig) -> None:
        """Put a handle at each robot, and at each bin that differs from those of other robots."""
        wanted = dict[str, tuple[Floats, tuple[bool, bool, bool], Callable[[Floats], Change]]]()
        for index, robot in enumerate(line.robots):
            place = np.array([robot.x, line.cell.belt.y[1] + 0.1, line.cell.belt.height + 0.05])
            wanted[f"/robot_{index}"] = place, (True, False, False), partial(_move, index, None)
        for owner in changes.bin_owners(line):
            x = line.robots[owner].x
            for number, bin_ in enumerate(line.robots[owner].bins or line.cell.bins.fixed):
                place = np.array([x + bin_.x, bin_.y, line.cell.bins.rim + 0.02])
                wanted[f"/bin_{owner}_{number}"] = place, (True, True, False), partial(_move, owner, number)
        for name in set(self._handles) - set(wanted):
            self._handles.pop(name).remove()
        for name, (place, axes, mover) in wanted.items():
            if name in self._handles:
                self._handles[name].position = place
                continue
            self._handles[name] = self._handle(name, place, axes, mover)

    def _handle(
        self, name: str, place: Floats, axes: tuple[bool, bool, bool], mover: Callable[[Floats], Change]
    ) -> Any:
        handle = self._scene.add_transform_controls(
            name,
            scale=GRIP,
            line_width=3.0,
            active_axes=axes,
            disable_rotations=True,
            disable_sliders=not axes[1],
            depth_test=False,
            opacity=0.85,
            position=place,
        )

        def moved(event: Any) -> None:
            if event.phase == "end" and event.client is not None:
                self._drag(mover(np.asarray(handle.position)))

        handle.on_update(moved)
        return handle


def _move(robot: int, number: int | None, place: Floats) -> Change:
    """What moves a robot, or one of its bins, to a place."""
    x, y = float(place[0]), float(place[1])
    return lambda line: (
        changes.move_robot(line, robot, x)
        if number is None
        else changes.move_bin(line, robot, number, x - line.robots[robot].x, y)
    )


def looks(line: LineConfig) -> tuple[Any, ...]:
    """What a picture of a line depends on."""
    cell = line.cell
    return line.robots, cell.bins, cell.belt, cell.items, cell.limits, cell.mix, line.camera


def split(solids: Mapping[str, Solids]) -> dict[str, Solids]:
    """Solids by shape, the transparent ones apart."""
    groups = dict[str, Solids]()
    for shape, group in solids.items():
        clear = group.rgba[:, 3] < 1.0
        for name, rows in ((shape, ~clear), (f"{shape}_clear", clear)):
            if rows.any():
                groups[name] = Solids(group.position[rows], group.wxyz[rows], group.half[rows], group.rgba[rows])
    return groups


def landing_cloud(answer: Answer) -> tuple[Floats, Any]:
    """Places at which the items come down around their bins (N, 3), and the colours of the items (N, 3)."""
    places, colours = [np.zeros((0, 3))], [np.zeros((0, 3))]
    line, counted = answer.line, answer.plan.counted
    landings = () if counted is None else counted.landings
    for robot in line.robots:
        for item, points in zip(line.cell.items, landings, strict=bool(landings)):
            bins = robot.bins or line.cell.bins.fixed
            bin_ = next((bin_ for bin_ in bins if bin_.takes(item)), None)
            if bin_ is None or (robot.skills and item not in robot.skills) or len(points) == 0:
                continue
            middle = np.array([robot.x + bin_.x, bin_.y, line.cell.bins.rim + 0.01])
            places.append(middle + np.column_stack([points, np.zeros(len(points))]))
            colours.append(np.tile(ITEMS[line.cell.items.index(item), :3], (len(points), 1)))
    return np.concatenate(places), (255.0 * np.concatenate(colours)).astype(np.uint8)
