from setuptools import find_packages, setup

name = "system_identification"

setup(
    name=name,
    version="0.1.0",
    description="Fits, noise and sets of unmodelled effects for any simulated system that is disturbed.",
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
    zip_safe=True,
)
