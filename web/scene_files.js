// What was dropped or chosen, as files with their names relative to what holds them all.

// Of what a drop carries; folders are read whole. Must be called while the event is handled.
export async function dropped_files(transfer) {
  const entries = [...transfer.items].map((item) => item.webkitGetAsEntry?.());
  if (!entries.some((entry) => entry?.isDirectory)) return chosen_files(transfer.files);
  const found = [];
  for (const entry of entries) if (entry) await read_entry(entry, '', found);
  return within(found);
}

export const chosen_files = (files) => within([...files].map((file) =>
  ({ name: file.webkitRelativePath || file.name, file })));

async function read_entry(entry, folder, found) {
  const name = folder + entry.name;
  if (entry.isFile) {
    const file = await new Promise((done, failed) => { entry.file(done, failed); });
    found.push({ name, file });
    return;
  }
  const reader = entry.createReader();
  for (;;) { // a call gives a hundred entries at most
    const some = await new Promise((done, failed) => { reader.readEntries(done, failed); });
    if (!some.length) return;
    for (const one of some) await read_entry(one, `${name}/`, found);
  }
}

// {title, files}: without the one folder that holds them all, whose name is the title.
function within(found) {
  const files = found.filter(({ file }) => !file.name.startsWith('.'));
  const top = files[0]?.name.split('/')[0];
  const held = files.every(({ name }) => name.startsWith(`${top}/`));
  if (!held) return { title: '', files };
  return { title: top,
    files: files.map(({ name, file }) => ({ name: name.slice(top.length + 1), file })) };
}
