// Files made in the page: CSV of a plot.

function download(name, content, type) {
  const link = element('a', { download: name, href: URL.createObjectURL(new Blob([content], { type })) });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

// Columns [{ head, values }] as CSV; a value that is not there is an empty cell. The page has
// single precision, so seven digits are all that is known.
function csv(columns) {
  const quoted = (text) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
  const cell = (value) => (value === null || value === undefined || Number.isNaN(value) ? '' : Number(value.toPrecision(7)));
  const lines = [columns.map((column) => quoted(column.head)).join(',')];
  for (let i = 0; i < columns[0].values.length; i++) {
    lines.push(columns.map((column) => cell(column.values[i])).join(','));
  }
  return lines.join('\n') + '\n';
}
