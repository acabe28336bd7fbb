// What a reader of a page needs: a name for every control and picture, no id twice, and contrast of text against what
// is behind it (WCAG 2.1: 4.5, of large text 3). The value is a list of complaints.
(() => {
  const found = [], seen = new Set(), start = (e) => e.outerHTML.slice(0, 80);
  const labels = (e) => [...(e.labels ?? [])].map((label) => label.textContent).join(" ");
  const named = (e) => (e.getAttribute("aria-label") || labels(e) || e.textContent || e.title || "").trim();
  for (const e of document.querySelectorAll("button, select, input, canvas[role=img], [tabindex]")) {
    if (!e.closest("[hidden]") && !named(e)) found.push(`no name: ${start(e)}`);
  }
  for (const e of document.querySelectorAll("[id]")) {
    if (seen.has(e.id)) found.push(`twice: ${e.id}`);
    seen.add(e.id);
  }
  for (const e of document.querySelectorAll("[aria-describedby]")) {
    if (!document.getElementById(e.getAttribute("aria-describedby"))) found.push(`nothing describes ${e.id}`);
  }
  const linear = (c) => (c / 255 <= 0.03928 ? c / 255 / 12.92 : ((c / 255 + 0.055) / 1.055) ** 2.4);
  const light = ([r, g, b]) => 0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b);
  const parsed = (text) => text.match(/[\d.]+/g).map(Number);
  const behind = (e) => {
    for (let each = e; each; each = each.parentElement) {
      const colour = parsed(getComputedStyle(each).backgroundColor);
      if (colour.length === 3 || colour[3] > 0) return colour;
    }
    return [255, 255, 255];
  };
  for (const e of document.querySelectorAll("body *")) {
    const own = [...e.childNodes].some((node) => node.nodeType === Node.TEXT_NODE && node.textContent.trim());
    if (!own || e.closest("[hidden], script, style, .hidden, option") || !e.getClientRects().length) continue;
    const style = getComputedStyle(e);
    const [dark, bright] = [light(parsed(style.color)), light(behind(e))].sort((a, b) => a - b);
    const ratio = (bright + 0.05) / (dark + 0.05);
    if (ratio < (parseFloat(style.fontSize) >= 24 ? 3 : 4.5)) found.push(`contrast ${ratio.toFixed(2)}: ${start(e)}`);
  }
  const width = document.documentElement.scrollWidth;
  if (width > innerWidth) found.push(`wider than the window: ${width} > ${innerWidth}`);
  if (!document.documentElement.lang || !document.title) found.push("no language or no title");
  return found;
})();
