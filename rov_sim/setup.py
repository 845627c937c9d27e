from setuptools import find_packages, setup

name = "rov_sim"

setup(
    name=name,
    version="0.1.0",
    description="Simulated benches and vehicles with their sensors.",
    license="Apache-2.0",
    maintainer="The maintainers",
    maintainer_email="maintainers@example.com",
    packages=find_packages(exclude=["test"]),
    package_data={name: ["vehicle/sensors/*.yaml", "vehicle_study/plans/*.yaml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{name}"]),
        (f"share/{name}", ["package.xml"]),
        (f"share/{name}/config", ["config/emulated_bench.yaml", "config/foxglove.json", "config/plotjuggler.xml"]),
        (f"share/{name}/launch", ["launch/bench.launch.py", "launch/vehicle.launch.py"]),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest", "hypothesis"]},
    entry_points={
        "console_scripts": [
            "bench_graph = rov_sim.cli_bench_graph:main",
            "bench_campaign = rov_sim.cli_bench_campaign:main",
            "bench_study = rov_sim.cli_bench_study:main",
            "bench_study_table = rov_sim.cli_bench_study_table:main",
            "emulated_bench = rov_sim.emulated_bench_node:main",
            "experiment_watch = rov_sim.experiment_watch_node:main",
            "plant = rov_sim.vehicle.plant_node:main",
            "rov_graph = rov_sim.cli_rov_graph:main",
            "rov_study = rov_sim.cli_rov_study:main",
            "scene = rov_sim.vehicle.scene_node:main",
            "reference = rov_sim.cli_reference:main",
            "score_experiment = rov_sim.cli_score_experiment:main",
            "score_vehicle = rov_sim.vehicle.cli_score_vehicle:main",
        ]
    },
    zip_safe=True,
)
