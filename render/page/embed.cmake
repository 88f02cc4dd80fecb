# Writes OUT: PAGE with MODULE in it, as base64.
execute_process(COMMAND base64 -w0 ${MODULE} OUTPUT_VARIABLE TAUT_MODULE COMMAND_ERROR_IS_FATAL ANY)
configure_file(${PAGE} ${OUT} @ONLY)
