// Keys of the whole page; fields and buttons keep their own.

function setUpKeys() {
  const step = (count) => clock.set(clock.t + (count * clock.end) / 200);
  const actions = {
    ' ': () => clock.toggle(),
    ArrowLeft: () => step(-1),
    ArrowRight: () => step(1),
    Home: () => clock.set(0),
    End: () => clock.set(clock.end),
    '+': () => view.camera && (zoom(view.camera, 0.9), drawSoon()),
    '-': () => view.camera && (zoom(view.camera, 1.1), drawSoon()),
    a: () => view.camera && (turn(view.camera, -0.1, 0), drawSoon()),
    d: () => view.camera && (turn(view.camera, 0.1, 0), drawSoon()),
    w: () => view.camera && (turn(view.camera, 0, 0.1), drawSoon()),
    s: () => view.camera && (turn(view.camera, 0, -0.1), drawSoon()),
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
