"""Simulates ropes, chains and cords, and renders them. SI units, y up, quaternions w, x, y, z."""
# The module's docstrings say more: help(taut).

import os
from math import inf
from typing import Any, Callable, Mapping, Sequence, Union

import numpy
from numpy.typing import ArrayLike, NDArray

Array = NDArray[numpy.float64]
Picture = NDArray[numpy.uint8]
Setting = Union[float, bool, str]
File = Union[str, os.PathLike[str]]

__version__: str

class Error(Exception): ...
class ArgumentError(Error, ValueError): ...

class SceneError(Error):
    file: str
    line: int
    column: int
    key: str

class AssetError(Error): ...

class DivergedError(Error):
    method: str
    time: float
    step: int
    connector: str
    link: int

class InterventionError(Error):
    time: float

class ContextError(Error): ...

def set_asset_folder(folder: File) -> None: ...
def load(file: File, set: Mapping[str, Any] = {}) -> Scene: ...
def faults(file: File, set: Mapping[str, Any] = {}) -> list[SceneError]: ...
def methods() -> dict[str, dict[str, Any]]: ...
def sweep(method: str, quick: bool = False) -> list[dict[str, Any]]: ...

class Path:
    def __init__(
        self, times: ArrayLike, positions: ArrayLike, rotations: ArrayLike | None = None, *, ease: bool = False
    ) -> None: ...
    def position(self, time: float) -> Array: ...

class World:
    def __init__(self, gravity: ArrayLike = (0.0, -9.81, 0.0)) -> None: ...
    def add_connector(
        self,
        name: str,
        positions: ArrayLike,
        mass: float | None = None,
        *,
        velocities: ArrayLike | None = None,
        restitution: float = 0.0,
        model: str = "links",
        links: str = "rigid",
        radius: float = 0.0,
        contact: str = "beads",
        touches_itself: bool = False,
        friction: float = 0.0,
        static_friction: float | None = None,
        breaks_at: float = inf,
        diameter: float | None = None,
        axial_stiffness: float | None = None,
        axial_damping: float = 0.0,
        bending_stiffness: float | None = None,
        bending_damping: float = 0.0,
        rest_curvature: ArrayLike = (0.0, 0.0, 0.0),
        twisting_stiffness: float | None = None,
        twisting_damping: float = 0.0,
        rest_twist: float = 0.0,
        taper: ArrayLike | None = None,
        material: Mapping[str, float] = {},
        drag: Mapping[str, float] = {},
    ) -> None: ...
    def add_body(
        self,
        name: str,
        mass: float,
        *,
        cylinder: ArrayLike | None = None,
        sphere: float | None = None,
        box: ArrayLike | None = None,
        position: ArrayLike = (0.0, 0.0, 0.0),
        rotation: ArrayLike = (1.0, 0.0, 0.0, 0.0),
        velocity: ArrayLike = (0.0, 0.0, 0.0),
        spin: ArrayLike = (0.0, 0.0, 0.0),
        path: Path | None = None,
        grip: ArrayLike = (0.0, 0.0, 0.0),
        contact: Mapping[str, Any] | None = None,
    ) -> None: ...
    def add_obstacle(
        self,
        name: str,
        *,
        plane: bool = False,
        sphere: float | None = None,
        capsule: ArrayLike | None = None,
        cylinder: ArrayLike | None = None,
        box: ArrayLike | None = None,
        rounding: float = 0.0,
        position: ArrayLike = (0.0, 0.0, 0.0),
        rotation: ArrayLike = (1.0, 0.0, 0.0, 0.0),
        path: Path | None = None,
        friction: float = 0.0,
        static_friction: float | None = None,
        restitution: float = 0.0,
        ignores: Sequence[str] = [],
    ) -> None: ...
    def add_touching(
        self,
        *,
        bodies: Sequence[str] = [],
        connectors: Sequence[str] = [],
        friction: float = 0.0,
        static_friction: float | None = None,
        restitution: float = 0.0,
    ) -> None: ...
    def join(self, connector: str, particle: int, other: str, other_particle: int) -> None: ...
    def add_winch(
        self, connector: str, *, first: ArrayLike | None = None, last: ArrayLike | None = None
    ) -> None: ...
    def add_pulley(
        self,
        name: str,
        from_connector: str,
        to_connector: str,
        *,
        inertia: float = 0.0,
        friction: float = 0.0,
        bearing: float = 0.0,
    ) -> None: ...
    def set_air(
        self, density: float = 1.225, *, wind: ArrayLike = (0.0, 0.0, 0.0), gusts: Path | None = None
    ) -> None: ...
    def add_force(self, connector: str, force: Callable[[float, Array, Array], ArrayLike]) -> None: ...
    def add_mass(self, connector: str, particle: int, mass: float) -> None: ...
    def hold(
        self,
        connector: str,
        particle: int,
        *,
        point: ArrayLike | None = None,
        body: str | None = None,
        path: Path | None = None,
        clamp: ArrayLike | None = None,
        turn: ArrayLike | None = None,
    ) -> None: ...
    def positions(self, connector: str) -> Array: ...
    def velocities(self, connector: str) -> Array: ...
    @property
    def connectors(self) -> list[str]: ...
    @property
    def obstacles(self) -> list[str]: ...
    @property
    def pulleys(self) -> list[str]: ...
    @property
    def bodies(self) -> list[str]: ...

class Simulation:
    def __init__(self, world: World, method: str = "direct", *, fps: float = 60.0, **settings: Setting) -> None: ...
    def advance(self, until: float) -> None: ...
    def save(self, file: File) -> None: ...
    def load(self, file: File) -> None: ...
    def pin(
        self,
        connector: str,
        along: float,
        *,
        point: ArrayLike | None = None,
        body: str | None = None,
        path: Path | None = None,
        over: float = 0.0,
    ) -> int: ...
    def move(
        self,
        pin: int,
        *,
        point: ArrayLike | None = None,
        body: str | None = None,
        path: Path | None = None,
        over: float = 0.0,
    ) -> None: ...
    def release(self, pin: int) -> None: ...
    def cut(self, connector: str, along: float) -> str: ...
    def positions(self, connector: str) -> Array: ...
    def velocities(self, connector: str) -> Array: ...
    def pose(self, body: str) -> Array: ...
    def passed(self, pulley: str) -> float: ...
    def forces(self) -> dict[str, Any]: ...
    @property
    def events(self) -> list[dict[str, Any]]: ...
    @property
    def time(self) -> float: ...
    @property
    def method(self) -> str: ...
    @property
    def settings(self) -> dict[str, Setting]: ...
    @property
    def connectors(self) -> list[str]: ...
    @property
    def bodies(self) -> list[str]: ...
    @property
    def kinetic_energy(self) -> float: ...
    @property
    def potential_energy(self) -> float: ...
    @property
    def stretch(self) -> float: ...
    @property
    def counters(self) -> dict[str, int]: ...
    @property
    def state_hash(self) -> str: ...

class Trajectory:
    @property
    def method(self) -> str: ...
    @property
    def times(self) -> Array: ...
    @property
    def positions(self) -> dict[str, Array]: ...
    @property
    def poses(self) -> dict[str, Array]: ...

class Scene:
    def simulation(self, method: str = "", **settings: Setting) -> Simulation: ...
    def simulate(self, method: str = "", **settings: Setting) -> Trajectory: ...
    def truth(self, *, quick: bool = False) -> Truth: ...
    def renderer(
        self,
        *,
        size: tuple[int, int] | None = None,
        samples: int = 4,
        backend: str = "auto",
        transparent: bool = False,
    ) -> Renderer: ...
    def render(
        self,
        time: float,
        *,
        size: tuple[int, int] | None = None,
        samples: int = 4,
        backend: str = "auto",
        transparent: bool = False,
    ) -> Picture: ...
    @property
    def file(self) -> str: ...
    @property
    def title(self) -> str: ...
    @property
    def duration(self) -> float: ...
    @property
    def fps(self) -> int: ...
    @property
    def frames(self) -> int: ...
    @property
    def size(self) -> tuple[int, int]: ...
    @property
    def method(self) -> str: ...
    @property
    def settings(self) -> dict[str, Setting]: ...
    @property
    def connectors(self) -> list[str]: ...
    @property
    def bodies(self) -> list[str]: ...

class Renderer:
    def draw(self, simulation: Simulation) -> Picture: ...
    def frame(self, time: float) -> Picture: ...
    @property
    def size(self) -> tuple[int, int]: ...

class Batch:
    def __init__(
        self,
        positions: ArrayLike,
        mass: ArrayLike,
        step: float,
        *,
        velocities: ArrayLike | None = None,
        end_mass: ArrayLike = 0.0,
        path: Path | None = None,
        gravity: ArrayLike = (0.0, -9.81, 0.0),
        dtype: str = "float64",
    ) -> None: ...
    def advance(self, until: float, threads: int = 0) -> None: ...
    @property
    def time(self) -> float: ...
    @property
    def positions(self) -> Array: ...
    @property
    def velocities(self) -> Array: ...

class Score:
    @property
    def method(self) -> str: ...
    @property
    def settings(self) -> dict[str, Setting]: ...
    @property
    def label(self) -> str: ...
    @property
    def outcome(self) -> str: ...
    @property
    def reason(self) -> str: ...
    @property
    def error(self) -> float: ...
    @property
    def cpu(self) -> float: ...
    @property
    def steps(self) -> float: ...
    @property
    def solves(self) -> float: ...
    @property
    def stretch(self) -> float: ...

class Truth:
    def score(self, method: str, *, cap: float = 60.0, **settings: Setting) -> Score: ...
    @property
    def horizon(self) -> float: ...
    @property
    def self_error(self) -> float: ...
    @property
    def length(self) -> float: ...
