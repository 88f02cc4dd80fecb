# Models of chains by SD/FAST's generator, where there is one: sim/README.md says how to get it. Nothing that it
# writes is kept in the sources.
find_program(TAUT_SDFAST sdfast DOC "SD/FAST's generator, for the method sdfast")
set(TAUT_SDFAST_LINKS 1 5 10 20 40 50 80 CACHE STRING "Numbers of links that the method sdfast has planar models for")
set(TAUT_SDFAST_BALL_LINKS 1 5 10 20 50 CACHE STRING "The same with ball joints")
# Kane's code grows with more than the square of the links: 1.3 MB for 10 on ball joints, 5 MB and minutes of
# compiling for 20.
set(TAUT_SDFAST_KANE_LINKS 1 5 10 20 40 CACHE STRING "As TAUT_SDFAST_LINKS, for Kane's formulation")
set(TAUT_SDFAST_BALL_KANE_LINKS 1 5 CACHE STRING "As TAUT_SDFAST_BALL_LINKS, for Kane's formulation")

set(folder ${CMAKE_CURRENT_BINARY_DIR}/sdfast)
file(MAKE_DIRECTORY ${folder})
set(declarations "")
set(rows "")

# The text of a model. A question mark makes a number one that is set at run time. Links are massless lines
# along y with a particle below; a ball joint needs inertia about the line too (sdfast/chain.h).
function(taut_sdfast_model joints links result)
  set(model "gravity = 0? 0? 0?\n")
  set(inboard "$ground")
  set(any_body "mass = 1?\n  inertia = 1? 0? 0? 0? 1? 0? 0? 0? 1?")
  set(arm "0 0 0")
  if(joints STREQUAL free)
    string(APPEND model "body = base joint = free\n  inboard = $ground\n  ${any_body}\n"
      "  bodytojoint = 0 0 0\n  inbtojoint = 0 0 0\n  pin = 1 0 0\n  pin = 0 1 0\n  pin = 0 0 1\n")
    set(inboard base)
    set(arm "0? 0? 0?")
  endif()
  foreach(i RANGE 1 ${links})
    if(joints STREQUAL pin)
      set(line "joint = pin\n  pin = 0 0 1\n  inertia = 0 0 0")
    else()
      set(line "joint = ball\n  inertia = 0 1? 0")
    endif()
    string(APPEND model "body = p${i} ${line}\n  inboard = ${inboard}\n  mass = 1?\n"
      "  bodytojoint = 0 1? 0\n  inbtojoint = ${arm}\n")
    set(inboard p${i})
    set(arm "0 0 0")
  endforeach()
  if(NOT joints STREQUAL pin)
    string(APPEND model "body = tip joint = ball\n  inboard = ${inboard}\n  ${any_body}\n"
      "  bodytojoint = 0? 0? 0?\n  inbtojoint = 0 0 0\n")
  endif()
  set(${result} "${model}" PARENT_SCOPE)
endfunction()

if(TAUT_SDFAST)
  enable_language(C)
  set(models "")
  set(pin_order_n ${TAUT_SDFAST_LINKS})
  set(pin_kane ${TAUT_SDFAST_KANE_LINKS})
  set(ball_order_n ${TAUT_SDFAST_BALL_LINKS})
  set(ball_kane ${TAUT_SDFAST_BALL_KANE_LINKS})
  set(free_order_n ${TAUT_SDFAST_BALL_LINKS})
  set(free_kane ${TAUT_SDFAST_BALL_KANE_LINKS})
  foreach(kind pin_order_n pin_kane ball_order_n ball_kane free_order_n free_kane)
    string(REGEX MATCH "^[a-z]+" joints ${kind})
    string(REPLACE "${joints}_" "" formulation ${kind})
    set(option "")
    if(formulation STREQUAL order_n)
      set(option -n)
    endif()
    foreach(links IN LISTS ${kind})
      taut_sdfast_model(${joints} ${links} model)
      set(name ${joints}${links}_${formulation})  # short: it breaks lines in longer names
      file(CONFIGURE OUTPUT ${folder}/${name}.sd CONTENT "${model}" @ONLY)
      set(made ${folder}/${name}_dyn.c ${folder}/${name}_sar.c ${folder}/${name}_lib.c)
      add_custom_command(
        OUTPUT ${made}
        COMMAND ${TAUT_SDFAST} -lc ${option} -ge -p ${name}_ ${name}.sd ${name}
        WORKING_DIRECTORY ${folder} DEPENDS ${folder}/${name}.sd VERBATIM)
      list(APPEND models ${made})
      string(APPEND declarations "TAUT_SDFAST_DECLARE(${name}_)\n")
      string(APPEND rows "    TAUT_SDFAST_ROW(${links}, ${joints}, ${formulation}, ${name}_),\n")
    endforeach()
  endforeach()
  # Its C is of 1989, and not ours to mend; without branches, it gains nothing from more than -O1.
  add_library(taut_sdfast_models OBJECT ${models})
  target_compile_options(taut_sdfast_models PRIVATE -std=gnu89 -w -O1)
  set_target_properties(taut_sdfast_models PROPERTIES POSITION_INDEPENDENT_CODE ON UNITY_BUILD OFF)
  target_sources(taut_reference PRIVATE $<TARGET_OBJECTS:taut_sdfast_models>)
endif()
configure_file(${CMAKE_CURRENT_LIST_DIR}/models.cpp.in ${folder}/models.cpp @ONLY)
target_sources(taut_reference PRIVATE ${folder}/models.cpp)
