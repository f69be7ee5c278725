# Toolchain file: programs for 64-bit Arm, by Debian's cross compiler. Libraries and headers are those
# in SPROUT_SYSROOT, which scripts/test_arm64 makes. What the build calls, such as protoc and lcm-gen, is
# this machine's; what was built runs under qemu.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(triplet aarch64-linux-gnu)
set(CMAKE_LIBRARY_ARCHITECTURE ${triplet})
set(CMAKE_C_COMPILER ${triplet}-gcc)
set(CMAKE_CXX_COMPILER ${triplet}-g++)
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64 -L "${SPROUT_SYSROOT}")

list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES SPROUT_SYSROOT)
set(CMAKE_SYSROOT "${SPROUT_SYSROOT}")
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
foreach(what LIBRARY INCLUDE PACKAGE)
  set(CMAKE_FIND_ROOT_PATH_MODE_${what} ONLY)
endforeach()
set(ENV{PKG_CONFIG_SYSROOT_DIR} "${SPROUT_SYSROOT}")
set(ENV{PKG_CONFIG_LIBDIR}
    "${SPROUT_SYSROOT}/usr/lib/${triplet}/pkgconfig:${SPROUT_SYSROOT}/usr/share/pkgconfig")
