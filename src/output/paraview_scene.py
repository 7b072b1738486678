# Frames a run's trajectory in ParaView: bodies as spheres of their radius, coloured by speed.
# SPDX-License-Identifier: BSD-3-Clause
"""usage: pvpython paraview_scene.py FOLDER    writes FOLDER/scene.pvsm, to be opened by ParaView,
and FOLDER/scene.png"""
import sys
from pathlib import Path

from paraview import simple


def main(folder):
    simple._DisableFirstRenderCameraReset()  # or the first picture would choose a camera of its own
    source = simple.Xdmf3ReaderS(FileName=[str(folder / "trajectory.xdmf")])
    source.UpdatePipeline()
    times = source.TimestepValues
    last = times[-1] if hasattr(times, "__getitem__") else times  # of one snapshot it is a number
    source.UpdatePipeline(last)

    speed = simple.Calculator(Input=source, ResultArrayName="speed", Function="mag(velocity)")
    view = simple.GetActiveViewOrCreate("RenderView")
    view.ViewTime = last
    view.ViewSize = [1280, 800]
    view.UseColorPaletteForBackground = 0
    view.Background = [1, 1, 1]
    view.OrientationAxesLabelColor = [0, 0, 0]
    bodies = simple.Show(speed, view)
    bodies.SetRepresentationType("Point Gaussian")
    bodies.ShaderPreset = "Sphere"
    bodies.ScaleByArray = 1  # by the radius itself
    bodies.SetScaleArray = ["POINTS", "radius"]
    bodies.UseScaleFunction = 0
    bodies.GaussianRadius = 1
    simple.ColorBy(bodies, ("POINTS", "speed"))
    low, high, fast = usual(source)
    colours = simple.GetColorTransferFunction("speed")
    colours.RescaleTransferFunction(0, fast)
    bodies.SetScalarBarVisibility(view, True)
    bar = simple.GetScalarBar(colours, view)
    bar.Title, bar.ComponentTitle = "speed, m/s", ""
    bar.TitleColor = bar.LabelColor = [0, 0, 0]

    # From the side, z up.
    centre = [(a + b) / 2 for a, b in zip(low, high)]
    size = max(b - a for a, b in zip(low, high)) or 1
    view.CameraFocalPoint = centre
    view.CameraPosition = [centre[0], centre[1] - 2.8 * size, centre[2] + 0.5 * size]
    view.CameraViewUp = [0, 0, 1]
    view.CenterOfRotation = centre
    simple.Render(view)
    simple.SaveScreenshot(str(folder / "scene.png"), view)
    simple.SaveState(str(folder / "scene.pvsm"))
    print(folder / "scene.pvsm")


def usual(source):
    """Low and high corner of a box in which 90 % of the bodies lie in each direction, and the speed
    of 95 %: single bodies that fly far off shrink and pale nothing."""
    import numpy as np
    from paraview import servermanager
    from vtk.util.numpy_support import vtk_to_numpy
    data = servermanager.Fetch(source)
    blocks = [data]
    while hasattr(blocks[0], "GetBlock"):
        blocks = [block.GetBlock(k) for block in blocks for k in range(block.GetNumberOfBlocks())]
    places = np.concatenate([vtk_to_numpy(block.GetPoints().GetData()) for block in blocks])
    radii = np.concatenate(
        [vtk_to_numpy(block.GetPointData().GetArray("radius")) for block in blocks])
    velocities = np.concatenate(
        [vtk_to_numpy(block.GetPointData().GetArray("velocity")) for block in blocks])
    margin = radii.max()
    return (np.quantile(places, 0.05, axis=0) - margin, np.quantile(places, 0.95, axis=0) + margin,
            np.quantile(np.linalg.norm(velocities, axis=1), 0.95))


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(Path(sys.argv[1]))
