from setuptools import find_packages, setup

name = "thruster_runtime"

setup(
    name=name,
    version="0.1.0",
    description="What every node needs once: executor switch, clean stop, QoS profiles, diagnostics, joins.",
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
    entry_points={"console_scripts": ["compose = thruster_runtime.compose:main"]},
    zip_safe=True,
)
