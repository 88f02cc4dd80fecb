#include "render/program/output.h"

namespace taut::program {

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
