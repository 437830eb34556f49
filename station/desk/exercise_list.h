#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/language/words.h"
#include "station/session/workplace.h"

// How the list of exercises is searched and ordered. Functions, any thread.
namespace enamel::station::desk {

// From this many exercises on the list has groups and can be searched: eight are seen at once.
inline constexpr size_t kLongList = 9;

// In the order in which the list shows them.
enum class ListGroup { kDue, kGraded, kPractice, kDone };
inline constexpr std::array kListGroups = {ListGroup::kDue, ListGroup::kGraded,
                                           ListGroup::kPractice, ListGroup::kDone};
// Key of the group's heading.
const char* HeadingOf(ListGroup group);

// Due: it can still be begun, and ends within a week or has ended. Done: no attempt is left.
ListGroup GroupOf(const Catalogue::Exercise& exercise, int64_t now_unix_ms);

// Whether every word that was typed is in one of the texts: in any order, parts of words too, small
// and capital Latin letters alike. Nothing typed finds everything.
bool Matches(std::string_view typed, std::span<const std::string> texts);

// Indices of the exercises of a group that match, those due first in order of their dates, else in
// the server's order.
std::vector<size_t> Listed(const language::Words& words,
                           std::span<const Catalogue::Exercise> exercises, ListGroup group,
                           std::string_view typed, int64_t now_unix_ms);

}  // namespace enamel::station::desk
