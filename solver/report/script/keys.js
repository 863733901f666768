// Keys of the whole page; fields and buttons keep their own.

function setUpKeys() {
  const step = (count) => clock.set(clock.t + (count * clock.end) / 200);
  const actions = {
    ' ': () => clock.toggle(),
    ArrowLeft: () => step(-1),
    ArrowRight: () => step(1),
    Home: () => clock.set(0),
    End: () => clock.set(clock.end),
  };
  addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.target.closest('input, select, button, a, summary')) return;
    const act = actions[event.key];
    if (!act) return;
    act();
    event.preventDefault();
  });
}
