from glob import glob

from setuptools import find_packages, setup

setup(
    name="bench_driver",
    version="0.1.0",
    description="Driver of the thruster bench: protocols, link, serial port, node, emulated device, firmware.",
    license="Apache-2.0",
    maintainer="The maintainers",
    maintainer_email="maintainers@example.com",
    packages=find_packages(exclude=["test"]),
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/bench_driver"]),
        ("share/bench_driver", ["package.xml"]),
        ("share/bench_driver/config", glob("config/*.yaml")),
        ("share/bench_driver/firmware", ["firmware/Makefile", "firmware/README.md"]),
        ("share/bench_driver/firmware/src", glob("firmware/src/*.[ch]")),
        ("share/bench_driver/firmware/emulator", glob("firmware/emulator/*.[ch]")),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["hypothesis", "pytest"]},
    zip_safe=True,
    entry_points={
        "console_scripts": [
            "driver = bench_driver.driver_node:main",
            "emulated_device = bench_driver.cli_emulated_device:main",
        ]
    },
)
