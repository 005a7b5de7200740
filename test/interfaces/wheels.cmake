# SPDX-License-Identifier: Apache-2.0
# The message packages that come as wheels name the include directories of the machine that built
# them, below /opt/python, and CMake refuses targets with directories that do not exist. This takes
# them out again once all packages are found; Python's own come from find_package(Python3).
# Given as CMAKE_PROJECT_TOP_LEVEL_INCLUDES; does nothing to packages of an installed ROS 2.
function(forget_the_machine_that_built_the_wheels)
  get_directory_property(targets IMPORTED_TARGETS)
  foreach(target IN LISTS targets)
    get_target_property(folders "${target}" INTERFACE_INCLUDE_DIRECTORIES)
    if(folders)
      list(FILTER folders EXCLUDE REGEX "^/opt/python/")
      set_target_properties("${target}" PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${folders}")
    endif()
  endforeach()
endfunction()

cmake_language(DEFER CALL forget_the_machine_that_built_the_wheels)
