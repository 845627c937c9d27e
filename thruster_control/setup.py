from setuptools import find_packages, setup

name = "thruster_control"

setup(
    name=name,
    version="0.1.0",
    description="Outer loop and allocation of a vehicle, inner control loops of its thrusters, set points and scores.",
    license="Apache-2.0",
    maintainer="The maintainers",
    maintainer_email="maintainers@example.com",
    packages=find_packages(exclude=["test"]),
    package_data={name: ["vehicle_scripts/*.yaml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{name}"]),
        (f"share/{name}", ["package.xml"]),
        (
            f"share/{name}/config",
            [
                "config/allocator.yaml",
                "config/inner_loop.yaml",
                "config/reference.yaml",
                "config/vehicle_reference.yaml",
            ],
        ),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest", "hypothesis", "scipy"]},
    entry_points={
        "console_scripts": [
            "allocator = thruster_control.allocator_node:main",
            "inner_loop = thruster_control.inner_loop_node:main",
            "reference = thruster_control.reference_node:main",
            "vehicle_reference = thruster_control.vehicle_reference_node:main",
        ]
    },
    zip_safe=True,
)
