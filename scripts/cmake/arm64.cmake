# Toolchain file: programs for 64-bit Arm from Debian's cross compiler. scripts/test_arm64 makes the
# folder SPROUT_SYSROOT, which holds libraries and headers for Arm. Programs that the build calls, such
# as protoc and lcm-gen, are this machine's; what was built runs under qemu.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(triplet aarch64-linux-gnu)
set(CMAKE_LIBRARY_ARCHITECTURE ${triplet})
set(CMAKE_C_COMPILER ${triplet}-gcc)
set(CMAKE_CXX_COMPILER ${triplet}-g++)

list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES SPROUT_SYSROOT)
set(CMAKE_SYSROOT "${SPROUT_SYSROOT}")
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
foreach(what LIBRARY INCLUDE PACKAGE)
  set(CMAKE_FIND_ROOT_PATH_MODE_${what} ONLY)
endforeach()
set(ENV{PKG_CONFIG_SYSROOT_DIR} "${SPROUT_SYSROOT}")
set(ENV{PKG_CONFIG_LIBDIR}
    "${SPROUT_SYSROOT}/usr/lib/${triplet}/pkgconfig:${SPROUT_SYSROOT}/usr/share/pkgconfig")

set(CMAKE_CROSSCOMPILING_EMULATOR "${SPROUT_SYSROOT}/run")
