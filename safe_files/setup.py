from setuptools import find_packages, setup

setup(
    name="safe_files",
    version="0.1.0",
    description="The one strict reader of YAML and of messages' bytes; files and folders written whole or not at all.",
    license="Apache-2.0",
    maintainer="The maintainers",
    maintainer_email="maintainers@example.com",
    packages=find_packages(exclude=["test"]),
    package_data={"safe_files": ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/safe_files"]),
        ("share/safe_files", ["package.xml"]),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest"]},
    zip_safe=True,
)
