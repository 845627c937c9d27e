from setuptools import find_packages, setup

name = "thruster_model"

setup(
    name=name,
    version="0.1.0",
    description="Models, parameter sets, compiled plants and identification of underwater thrusters.",
    license="Apache-2.0",
    maintainer="The maintainers",
    maintainer_email="maintainers@example.com",
    packages=find_packages(exclude=["test"]),
    package_data={name: ["parameter_sets/*.yaml", "vehicle_sets/*.yaml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{name}"]),
        (f"share/{name}", ["package.xml"]),
        (f"share/{name}/config", ["config/t200_columns.yaml"]),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest", "hypothesis"]},
    entry_points={
        "console_scripts": [
            "attitude_fit = thruster_model.cli_attitude_fit:main",
            "fit = thruster_model.cli_fit:main",
            "fit_table = thruster_model.cli_fit_table:main",
            "force_table = thruster_model.cli_force_table:main",
            "class_table = thruster_model.cli_class_table:main",
            "reference = thruster_model.cli_reference:main",
            "new_set = thruster_model.cli_new_set:main",
            "new_vehicle = thruster_model.cli_new_vehicle:main",
            "load_cell = thruster_model.cli_load_cell:main",
            "log_effects = thruster_model.cli_log_effects:main",
        ]
    },
    zip_safe=True,
)
