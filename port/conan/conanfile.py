from conan import ConanFile
from conan.tools.cmake import CMake, CMakeToolchain, cmake_layout


class Rigcal(ConanFile):
    name = "rigcal"
    version = "@VERSION@"
    description = "Extrinsic calibration of camera rigs, with no heap and no dependency"
    license = "MIT"
    package_type = "library"
    settings = "os", "arch", "compiler", "build_type"
    options = {"shared": [True, False], "fPIC": [True, False], "real": ["double", "float"]}
    default_options = {"shared": False, "fPIC": True, "real": "double"}
    implements = ["auto_shared_fpic"]
    languages = "C"
    exports_sources = "CMakeLists.txt", "include/*", "src/*", "LICENSE"

    def layout(self):
        cmake_layout(self)

    def generate(self):
        toolchain = CMakeToolchain(self)
        toolchain.cache_variables["RIGCAL_REAL"] = str(self.options.real)
        toolchain.cache_variables["RIGCAL_BUILD_TESTS"] = False
        toolchain.cache_variables["RIGCAL_BUILD_EXAMPLES"] = False
        toolchain.generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        CMake(self).install()

    def package_info(self):
        self.cpp_info.libs = ["rigcal"]
        self.cpp_info.set_property("cmake_file_name", "rigcal")
        self.cpp_info.set_property("cmake_target_name", "rigcal::rigcal")
        if self.options.real == "float":
            self.cpp_info.defines.append("RIGCAL_USE_FLOAT=1")
        if self.options.shared:
            self.cpp_info.defines.append("RIGCAL_SHARED")
        if self.settings.os in ("Linux", "FreeBSD"):
            self.cpp_info.system_libs = ["m"]
