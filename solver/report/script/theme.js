// Light and dark: that of the system until the button is pressed.

const shade = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const themeListeners = [];

function isDark() {
  const chosen = document.documentElement.dataset.theme;
  return chosen ? chosen === 'dark' : matchMedia('(prefers-color-scheme: dark)').matches;
}

function setUpTheme() {
  const press = document.getElementById('theme');
  const tell = () => {
    press.textContent = isDark() ? 'light' : 'dark';
    for (const listener of themeListeners) listener();
  };
  press.addEventListener('click', () => {
    document.documentElement.dataset.theme = isDark() ? 'light' : 'dark';
    tell();
  });
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', tell);
  document.getElementById('print').addEventListener('click', () => window.print());
  // Paper is light; plots and pictures take their colours before it is printed.
  let chosen = null;
  addEventListener('beforeprint', () => {
    chosen = document.documentElement.dataset.theme;
    document.documentElement.dataset.theme = 'light';
  });
  addEventListener('afterprint', () => {
    if (chosen) document.documentElement.dataset.theme = chosen;
    else delete document.documentElement.dataset.theme;
    tell();
  });
  tell();
}
