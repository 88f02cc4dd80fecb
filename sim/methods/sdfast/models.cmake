# Models of chains by SD/FAST's generator, where there is one: README.md says how to get it. Nothing that it
# writes is kept in the sources.
find_program(TAUT_SDFAST sdfast DOC "SD/FAST's generator, for the method sdfast")
set(TAUT_SDFAST_LINKS 1 5 10 20 40 CACHE STRING "Numbers of links that the method sdfast has models for")

set(folder ${CMAKE_CURRENT_BINARY_DIR}/sdfast)
file(MAKE_DIRECTORY ${folder})
set(declarations "")
set(rows "")
if(TAUT_SDFAST)
  enable_language(C)
  foreach(links IN LISTS TAUT_SDFAST_LINKS)
    # Point masses, each on a pin joint across the plane at one end of a massless line to the one before.
    # A question mark makes a number one that is set at run time.
    set(model "gravity = 0? 0? 0?\n")
    set(inboard "$ground")
    foreach(i RANGE 1 ${links})
      string(APPEND model "body = p${i} joint = pin\n  inboard = ${inboard}\n  mass = 1?\n  inertia = 0 0 0\n"
        "  bodytojoint = 0 1? 0\n  inbtojoint = 0 0 0\n  pin = 0 0 1\n")
      set(inboard p${i})
    endforeach()
    foreach(formulation order_n kane)
      set(name chain${links}_${formulation})
      set(option "")
      if(formulation STREQUAL order_n)
        set(option -n)
      endif()
      file(CONFIGURE OUTPUT ${folder}/${name}.sd CONTENT "${model}" @ONLY)
      set(made ${folder}/${name}_dyn.c ${folder}/${name}_sar.c ${folder}/${name}_lib.c)
      add_custom_command(
        OUTPUT ${made}
        COMMAND ${TAUT_SDFAST} -lc ${option} -ge -p ${name}_ ${name}.sd ${name}
        WORKING_DIRECTORY ${folder} DEPENDS ${folder}/${name}.sd VERBATIM)
      target_sources(taut_sim PRIVATE ${made})
      # Its C is of 1989, and not ours to mend.
      set_source_files_properties(${made} PROPERTIES COMPILE_OPTIONS "-std=gnu89;-w;-Wno-error")
      string(APPEND declarations "TAUT_SDFAST_DECLARE(${name}_)\n")
      string(APPEND rows "    TAUT_SDFAST_ROW(${links}, Formulation::${formulation}, ${name}_),\n")
    endforeach()
  endforeach()
endif()
configure_file(${CMAKE_CURRENT_LIST_DIR}/models.cpp.in ${folder}/models.cpp @ONLY)
target_sources(taut_sim PRIVATE ${folder}/models.cpp)
