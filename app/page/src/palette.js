// SPDX-License-Identifier: Apache-2.0
// Colours that mean something: the same in the page, in the program's figures (cmake/palette.cmake) and in those of Python.
// Both read what stands between the outer braces, as JSON. test/colors.test.mjs tests that colour-blind viewers tell them apart.
export default {
  "light": {"normal": "#2f7fe0", "tangential": "#e0632f", "x": "#b3123f", "y": "#5aa61c", "z": "#2f43d8"},
  "dark": {"normal": "#5b9df0", "tangential": "#f0814e", "x": "#d4607c", "y": "#93e06a", "z": "#8f86ff"},
  "fingers": ["#1fa2ff", "#e0810c", "#007f63", "#8034d4", "#8a3208"],
  "others": ["#d6479b", "#8c8c00", "#222222", "#00457a", "#5fb3b3"],
  "stuck": "#0a3f8f", "slipping": "#e01b1b", "at_limit": "#4bd2ff",
  "outcomes": {
    "held": "#dcefe0", "task done": "#c4e3cb", "free": "#dcefe0", "two points": "#a8d5b5", "over limits": "#cdb6e0",
    "slipping": "#f5d27a", "resting": "#c9c39a", "task failed": "#e0a58c", "outside": "#d9d9d9", "jammed": "#e39ab0",
    "wedged": "#8c2347", "unstable": "#de6b4e", "lost": "#a34a28", "off target": "#9db8d9", "solver failed": "#3d2b56",
    "refused": "#f4f4f4"
  }
};
