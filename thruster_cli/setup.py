from setuptools import find_packages, setup

name = "thruster_cli"

setup(
    name=name,
    version="0.1.0",
    description="One command for recordings, parameter sets, fits and diagnoses of thrusters.",
    license="Apache-2.0",
    maintainer="The maintainers",
    maintainer_email="maintainers@example.com",
    packages=find_packages(exclude=["test"]),
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{name}"]),
        (f"share/{name}", ["package.xml"]),
        ("bin", ["bin/thruster"]),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest"]},
    entry_points={"console_scripts": ["thruster = thruster_cli.cli_thruster:main"]},
    zip_safe=True,
)
