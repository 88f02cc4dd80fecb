# A command of taut in parts on this machine, and their merge:
#   make -f parts.mk -j 4 N=16 COMMAND='render scenes/nunchaku.toml'
# Given again after parts were stopped or killed, it does what they had left to do.
TAUT ?= taut
N ?= 8
ifndef COMMAND
$(error expected COMMAND='render SCENE', or chart, stability, work-precision with what they take)
endif

parts := $(addprefix part-,$(shell seq $(N)))
.PHONY: merge $(parts)

merge: $(parts)
	$(TAUT) $(COMMAND) --merge

$(parts): part-%:
	$(TAUT) $(COMMAND) --part $*/$(N) --threads 1 --quiet
