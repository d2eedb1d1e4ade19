#include "demo/progress.h"

#include <unistd.h>

#include <cstdio>

thenar::Progress progress_line(const thenar::Scene& scene, bool quiet) {
  if (quiet || isatty(STDERR_FILENO) == 0) return {};
  return [duration_s = scene.duration_s, shown_s = 0.0](double simulated_s, double wall_s) mutable {
    if (wall_s - shown_s < 0.1 && simulated_s < duration_s) return;
    shown_s = wall_s;
    std::fprintf(stderr, "\r%.2f of %.2f s simulated, %.1f times real time ", simulated_s, duration_s,
                 simulated_s / wall_s);
  };
}
