// Tables sort by the column whose heading is pressed; a second press reverses the order.

function setUpTables() {
  for (const table of document.querySelectorAll('table.sortable')) {
    if (table.tBodies[0].rows.length < 2) continue;
    [...table.tHead.rows[0].cells].forEach((head, column) => {
      const press = element('button', { type: 'button', class: 'sort' });
      press.append(...head.childNodes);
      head.append(press);
      press.addEventListener('click', () => sortTable(table, column));
    });
  }
}

function sortTable(table, column) {
  const heads = [...table.tHead.rows[0].cells];
  const down = heads[column].getAttribute('aria-sort') === 'ascending';
  const key = (row) => {
    const cell = row.cells[column];
    return cell.dataset.v === undefined ? cell.textContent : Number(cell.dataset.v);
  };
  const order = (a, b) => {
    const [x, y] = [key(a), key(b)];
    if (typeof x === 'number' && typeof y === 'number') return x - y;
    if (typeof x !== typeof y) return typeof x === 'number' ? -1 : 1; // a dash is last
    return x.localeCompare(y, undefined, { numeric: true });
  };
  const rows = [...table.tBodies[0].rows].sort(order);
  if (down) rows.reverse();
  heads.forEach((head) => head.removeAttribute('aria-sort'));
  heads[column].setAttribute('aria-sort', down ? 'descending' : 'ascending');
  table.tBodies[0].append(...rows);
}
