// Puts the address, which restores the whole view, into the clipboard.

export async function share_link(status) {
  try {
    await navigator.clipboard.writeText(location.href);
    status.textContent = 'Copied.';
  } catch {
    // No clipboard without encryption, but on the machine's own address.
    status.textContent = 'Copy it from the address bar.';
  }
}
