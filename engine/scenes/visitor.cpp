// SPDX-License-Identifier: Apache-2.0
#include "engine/scenes/visitor.h"

namespace thenar {

bool may_be_missing(const KeyRow& row) { return row.without.starts_with('(') && !row.without.starts_with("(Required"); }

// Here and not in the header: no room may have copies of them that is optimised less than this one.
Visitor::~Visitor() = default;
void Visitor::per_joint(const KeyRow&, Eigen::VectorXd&, Eigen::Index) {}
std::string Visitor::word(const KeyRow&, std::string_view now) { return std::string(now); }
bool Visitor::chooses(std::string_view, bool now) { return now; }
bool Visitor::when(bool has_it) const { return has_it; }
bool Visitor::is_there(std::string_view, bool now) { return now; }
bool Visitor::reads() const { return false; }
bool Visitor::has(std::string_view) { return false; }
void Visitor::refuse(std::string_view, std::string_view) {}
bool Visitor::is_refused(std::string_view) { return false; }
void Visitor::use_default(std::string_view, std::string_view) {}
std::string Visitor::location(std::string_view) { return ""; }
void Visitor::number(const KeyRow&, double&) {}
void Visitor::numbers(const KeyRow&, Eigen::Ref<Eigen::VectorXd>) {}
void Visitor::count(const KeyRow&, Eigen::Index&) {}
void Visitor::rotation(const KeyRow&, Eigen::Matrix3d&) {}
void Visitor::flag(const KeyRow&, bool&) {}
void Visitor::text(const KeyRow&, std::string&) {}
void Visitor::texts(const KeyRow&, std::vector<std::string>&) {}
void Visitor::path(const KeyRow&, std::filesystem::path&) {}
std::string Visitor::choice_of(const KeyRow&, std::string_view now) { return std::string(now); }
void Visitor::enter(const KeyRow&, KeyKind) {}
bool Visitor::is_map(std::string_view, bool now) { return now; }
void Visitor::enter_in_place(const KeyRow& row) { enter(row, KeyKind::kMap); }
std::size_t Visitor::begin_list(const KeyRow&, std::size_t now) { return now; }
void Visitor::begin_item(const KeyRow&, std::size_t) {}
void Visitor::end_list() {}
void Visitor::leave() {}

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
