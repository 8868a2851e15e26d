"""Tells catkin where the generator's solids live; not meant to be run by hand."""

from distutils.core import setup

from catkin_pkg.python_setup import generate_distutils_setup

setup(
    **generate_distutils_setup(
        packages=[
            "telex_cad",
            "telex_cad.files",
            "telex_cad.hull_parts",
            "telex_cad.upper",
        ],
        package_dir={"": "cad"},
    )
)
