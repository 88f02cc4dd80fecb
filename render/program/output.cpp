#include "render/program/output.h"

#include "sim/motion/printable.h"

namespace taut::program {

void write_text(std::string_view text) {
  render::write_output(printable_lines(text));
}

bool to_standard_output(const std::string& name) {
  return name == "-" || render::is_standard_output(name);
}

Output::Output(const std::string& name) {
  if (!to_standard_output(name)) file_.emplace(name);
}

void Output::write(std::string_view bytes) {
  if (file_) {
    file_->write(bytes);
  } else {
    render::write_output(bytes);
  }
  written_ += bytes.size();
}

void Output::finish() {
  if (file_) file_->commit();
}

}  // namespace taut::program
