from setuptools import find_packages, setup

name = "thruster_estimation"

setup(
    name=name,
    version="0.1.0",
    description="State estimators of a thruster, each with its uncertainty and status.",
    license="Apache-2.0",
    maintainer="The maintainers",
    maintainer_email="maintainers@example.com",
    packages=find_packages(exclude=["test"]),
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{name}"]),
        (f"share/{name}", ["package.xml"]),
        (f"share/{name}/config", ["config/navigation.yaml", "config/observer.yaml"]),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest", "filterpy", "scipy"]},
    entry_points={
        "console_scripts": [
            "navigation = thruster_estimation.navigation_node:main",
            "observer = thruster_estimation.observer_node:main",
            "replay = thruster_estimation.cli_replay:main",
        ]
    },
    zip_safe=True,
)
