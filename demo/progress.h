#pragma once

#include "engine/monolithic.h"

/// Tells on a line of stderr how far a run is, if somebody is looking; else nothing.
[[nodiscard]] thenar::Progress progress_line(const thenar::Scene& scene, bool quiet);
