"""Distances of arm, hand and workcell as Drake's SceneGraph measures them on the models, under the names of ``systems.arm.puma_body``."""

import numpy as np
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

from vipr.models import model_path
from vipr.systems.arm.collision import ArmBody
from vipr.systems.arm.shapes import Shape

LINKS = {
    "link_0": "column",
    "link_1": "trunk",
    "link_2": "upper_arm",
    "link_3": "forearm",
    "link_5": "wrist",
    "link_6": "flange",
    "room": "floor",
    "plate": "stage",
}


class ModelDistances:
    """The workcell's models without an object, in any configuration."""

    def __init__(self):
        builder = DiagramBuilder()
        self._plant, self._scene = AddMultibodyPlantSceneGraph(builder, 0.002)
        parser = Parser(self._plant)
        parser.package_map().AddPackageXml(str(model_path("package.xml")))
        parser.AddModels(url="package://vipr/workcell/workcell.dmd.yaml")
        self._plant.Finalize()
        self._diagram = builder.Build()
        self._context = self._diagram.CreateDefaultContext()
        inspector, self.names = self._scene.model_inspector(), {}
        for geometry in inspector.GetAllGeometryIds():
            if inspector.GetProximityProperties(geometry) is not None:
                link = inspector.GetName(inspector.GetFrameId(geometry)).split("::")[-1]
                self.names[geometry] = LINKS.get(link, link)

    def all(self, q: np.ndarray, hand: np.ndarray) -> dict[frozenset, float]:
        """``{pair of names: distance [m]}`` of all pairs closer than a metre at arm q (6,) and hand (8,) [rad]; negative: overlap."""
        context = self._plant.GetMyContextFromRoot(self._context)
        for name, angles in (("puma560", q), ("barrett_hand", hand)):
            self._plant.SetPositions(context, self._plant.GetModelInstanceByName(name), angles)
        query = self._scene.get_query_output_port().Eval(self._scene.GetMyContextFromRoot(self._context))
        return {
            frozenset((self.names[r.id_A], self.names[r.id_B])): r.distance
            for r in query.ComputeSignedDistancePairwiseClosestPoints(1.0)
        }

    def smallest(self, q: np.ndarray, hand: np.ndarray, body: ArmBody, obstacles: tuple[Shape, ...]) -> float:
        """The smallest distance [m] among the pairs that ``body.clearance`` looks at; 1 m if none is closer."""
        names = [shape.name for shape in (*body.shapes, *obstacles)]
        watched = {frozenset((names[a], names[b])) for a, b in zip(*body.pairs_with(len(obstacles)), strict=True)}
        return min((d for pair, d in self.all(q, hand).items() if pair in watched), default=1.0)
