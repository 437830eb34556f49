#pragma once

#include <boost/json/object.hpp>

#include "server/agreement/marks.h"

// Figures as JSON: {"value", "low", "high"}, or {"value": null, "why"}. For this folder.
namespace enamel::server {

boost::json::object FigureJson(const Agreement& agreement);
boost::json::object FigureJson(const Figure& figure);

Figure FigureOf(const Result<Agreement>& result);

}  // namespace enamel::server
