from setuptools import find_packages, setup

name = "gap_diagnosis"

setup(
    name=name,
    version="0.1.0",
    description="Diagnosis of the gap between a simulated thruster and a recorded one.",
    license="Apache-2.0",
    maintainer="The maintainers",
    maintainer_email="maintainers@example.com",
    packages=find_packages(exclude=["test"]),
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{name}"]),
        (f"share/{name}", ["package.xml"]),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest", "hypothesis"]},
    entry_points={
        "console_scripts": [
            "check = gap_diagnosis.cli_check:main",
            "compare = gap_diagnosis.cli_compare:main",
            "diagnose = gap_diagnosis.cli_diagnose:main",
            "diagnosis_table = gap_diagnosis.cli_diagnosis_table:main",
            "steady_states = gap_diagnosis.cli_steady_states:main",
            "blind_check = gap_diagnosis.blind_check.cli_blind_check:main",
            "scoreboard = gap_diagnosis.scoreboard.cli_scoreboard:main",
            "check_vehicle = gap_diagnosis.vehicle.cli_check_vehicle:main",
            "diagnose_vehicle = gap_diagnosis.vehicle.cli_diagnose_vehicle:main",
            "fit_vehicle = gap_diagnosis.vehicle.cli_fit_vehicle:main",
            "pulses = gap_diagnosis.vehicle.cli_pulses:main",
            "blind_vehicle = gap_diagnosis.vehicle.blind.cli_blind_vehicle:main",
            "sealed_vehicle = gap_diagnosis.vehicle.cli_sealed_vehicle:main",
            "trend = gap_diagnosis.vehicle.cli_trend:main",
            "watch = gap_diagnosis.vehicle.watch_node:main",
            "watch_rate = gap_diagnosis.vehicle.blind.cli_watch_rate:main",
            "watch_run = gap_diagnosis.vehicle.cli_watch_run:main",
            "sealed_case = gap_diagnosis.blind_check.cli_sealed_case:main",
        ]
    },
    zip_safe=True,
)
