from setuptools import find_packages, setup

setup(
    name="run_bag",
    version="0.1.0",
    packages=find_packages(exclude=["test"]),
    package_data={"run_bag": ["py.typed", "topics.yaml", "report/assets/*", "report/plotly_js/*"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/run_bag"]),
        ("share/run_bag", ["package.xml"]),
    ],
    # what pip has to bring is pinned in the requirements of the workspace
    extras_require={"test": ["hypothesis", "pytest"]},
    zip_safe=False,
    maintainer="The maintainers",
    maintainer_email="maintainers@example.com",
    description="Runs of thrusters and vehicles as MCAP bags: record, play, write, read into arrays, import, report.",
    license="Apache-2.0",
    entry_points={
        "console_scripts": [
            "compare = run_bag.cli_compare:main",
            "import_bench = run_bag.importers.cli_bench:main",
            "import_csv = run_bag.importers.cli_recording:main",
            "import_recording = run_bag.importers.cli_recording:main",
            "import_pool = run_bag.importers.cli_pool:main",
            "info = run_bag.cli_info:main",
            "overview = run_bag.cli_overview:main",
            "play = run_bag.live.player_node:main",
            "recorder = run_bag.live.recorder_node:main",
            "recover = run_bag.cli_recover:main",
            "show = run_bag.cli_show:main",
        ],
    },
)
