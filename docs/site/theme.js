// SPDX-License-Identifier: Apache-2.0
// Light or dark: as the system has it, until the reader chooses. Debian's furo has colours for both, but its own script
// does not run, since it imports another one without being a module; where furo's script runs, this one does nothing.
window.addEventListener('load', () => {
  if (!document.documentElement.classList.contains('no-js')) return;
  document.documentElement.classList.remove('no-js');
  const system = window.matchMedia('(prefers-color-scheme: dark)');
  const show = () => {
    document.body.dataset.theme = localStorage.getItem('theme') || (system.matches ? 'dark' : 'light');
  };
  system.addEventListener('change', show);
  for (const button of document.getElementsByClassName('theme-toggle')) {
    button.addEventListener('click', () => {
      localStorage.setItem('theme', document.body.dataset.theme === 'dark' ? 'light' : 'dark');
      show();
    });
  }
  show();
});
