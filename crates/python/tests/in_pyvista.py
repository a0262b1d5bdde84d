"""A pytest plugin that replaces pyvista's ray traces and interior points with intertri's, so that
pyvista's own tests exercise intertri. The tests come with pyvista's source distribution:

    pip download --no-deps --no-binary :all: pyvista && tar xf pyvista-*.tar.gz && cd pyvista-*
    PYTHONPATH=.../crates/python/tests python -m pytest -p in_pyvista tests/core -k "ray_trace or interior or intersect"
"""

import intertri.pyvista
import pyvista

pyvista.PolyDataFilters.ray_trace = intertri.pyvista.ray_trace
pyvista.PolyDataFilters.multi_ray_trace = intertri.pyvista.multi_ray_trace
pyvista.DataSetFilters.select_interior_points = intertri.pyvista.select_interior_points


def pytest_report_header():
    return f"pyvista {pyvista.__version__} from {pyvista.__path__[0]}, with ray traces and interior points by intertri"
