#include "engine/scenes/visitor.h"

namespace thenar {

bool may_be_missing(const KeyRow& row) { return row.without.starts_with('(') && !row.without.starts_with("(Required"); }

std::vector<std::string_view> Visitor::words_of_choice(std::string_view range) {
  std::vector<std::string_view> words;
  for (;;) {
    const std::size_t end = range.find(" | ");
    words.push_back(range.substr(0, end));
    if (end == range.npos) return words;
    range.remove_prefix(end + 3);
  }
}

}  // namespace thenar
