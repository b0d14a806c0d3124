"""Polylines written as STEP wires.

In: arrays of points. Out: a STEP file in millimetres.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from OCP.APIHeaderSection import APIHeaderSection_MakeHeader
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakePolygon
from OCP.gp import gp_Pnt
from OCP.IFSelect import IFSelect_RetDone
from OCP.Interface import Interface_Static
from OCP.STEPControl import STEPControl_AsIs, STEPControl_Writer
from OCP.TCollection import TCollection_HAsciiString

from brep_slicer.errors import InputError

from .shapes import compound
from .silence import silenced


def write_step_wires(polylines: Iterable[np.ndarray], path: str, *, description: str) -> None:
    """One wire per polyline (n, 3), mm; `description` goes into the header of the file.

    Raises
    ------
    InputError
        If OCCT cannot write the file.
    """
    wires = []
    for points in polylines:
        maker = BRepBuilderAPI_MakePolygon()
        keep = np.append(True, np.linalg.norm(np.diff(points, axis=0), axis=1) > 1e-6)
        for x, y, z in points[keep]:
            maker.Add(gp_Pnt(float(x), float(y), float(z)))
        if keep.sum() > 1:
            wires.append(maker.Wire())
    with silenced():
        writer = STEPControl_Writer()
        Interface_Static.SetCVal_s("write.step.unit", "MM")
        writer.Transfer(compound(wires), STEPControl_AsIs)
        header = APIHeaderSection_MakeHeader(writer.Model())
        header.SetDescriptionValue(1, TCollection_HAsciiString(description))
        if writer.Write(path) != IFSelect_RetDone:
            raise InputError(f"{path}: OCCT cannot write this STEP file; check space and permissions")
