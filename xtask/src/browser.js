// What a page of this program must hold, asked of the page itself in a real browser. The answer goes to the frame around it.
'use strict';
(() => {
  const said = [];
  const complain = what => said.push(String(what).slice(0, 300));
  for (const level of ['error', 'warn']) console[level] = (...all) => complain(`console.${level}: ${all.join(' ')}`);
  addEventListener('error', e => complain(`error: ${e.message}`));
  addEventListener('securitypolicyviolation', e => complain(`fetches ${e.blockedURI} (${e.violatedDirective})`));

  const shown = element => {
    const box = element.getBoundingClientRect();
    return box.width > 0 && box.height > 0 && getComputedStyle(element).visibility !== 'hidden';
  };
  const parts = colour => (colour.match(/[\d.]+/g) ?? []).map(Number);
  const luminance = ([r, g, b]) => [r, g, b].reduce((sum, c, i) => {
    const v = c / 255;
    return sum + [0.2126, 0.7152, 0.0722][i] * (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
  }, 0);
  const background = element => {
    for (let at = element; at; at = at.parentElement) {
      const colour = parts(getComputedStyle(at).backgroundColor);
      if (colour.length === 3 || colour[3] === 1) return colour;
    }
    return [255, 255, 255];
  };
  const texts = () => {
    const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT), found = [];
    while (walker.nextNode()) {
      const parent = walker.currentNode.parentElement;
      if (walker.currentNode.data.trim() && !['SCRIPT', 'STYLE'].includes(parent.tagName) && shown(parent)) found.push([parent, walker.currentNode.data.trim()]);
    }
    return found;
  };

  addEventListener('load', async () => {
    const width = document.documentElement.clientWidth;
    if (document.documentElement.scrollWidth > width) complain(`the page is ${document.documentElement.scrollWidth} px wide in ${width}`);
    for (const table of document.querySelectorAll('.table')) {
      if (table.scrollWidth > table.clientWidth) complain(`a table is ${table.scrollWidth} px wide in ${table.clientWidth}: ${table.textContent.slice(0, 60)}`);
    }
    for (const [parent, text] of texts()) {
      const style = getComputedStyle(parent), size = parseFloat(style.fontSize) * (parent.getScreenCTM?.().d ?? 1);
      if (size < 11) complain(`${size} px: ${text.slice(0, 40)}`);
      const svg = parent.namespaceURI.endsWith('svg');
      const ink = luminance(parts(svg ? style.fill : style.color)), paper = luminance(background(parent));
      const contrast = (Math.max(ink, paper) + 0.05) / (Math.min(ink, paper) + 0.05);
      if (contrast < 4.5) complain(`contrast ${contrast.toFixed(2)}: ${text.slice(0, 40)}`);
    }
    for (const figure of document.querySelectorAll('figure')) {
      if (figure.getBoundingClientRect().height > 980) complain('a figure is higher than a sheet of paper');
    }
    for (const grid of document.querySelectorAll('.grid')) {
      const boxes = [...grid.querySelectorAll('text')].filter(shown).map(text => [text.getBoundingClientRect(), text.textContent]);
      boxes.forEach(([a, one], k) => boxes.slice(k + 1).forEach(([b, other]) => {
        const apart = a.right <= b.left || b.right <= a.left || a.bottom <= b.top || b.bottom <= a.top;
        if (!apart) complain(`${one} and ${other} stand on one another`);
      }));
    }
    for (const element of document.querySelectorAll('a[href], button, summary, [tabindex]')) {
      if (element.tabIndex > 0) complain(`${element.tagName} leaves the order of the page`);
      element.focus({ preventScroll: true });
      if (document.activeElement === element && getComputedStyle(element).outlineStyle === 'none') complain(`${element.tagName} does not show that it is chosen`);
      if (!element.textContent.trim() && !element.getAttribute('aria-label')) complain(`${element.tagName} has no name`);
    }
    const plots = [...document.querySelectorAll('.plot')];
    for (const plot of plots) {
      const marks = plot.querySelector('.marks'), whole = marks.getAttribute('viewBox');
      const press = key => plot.dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true, cancelable: true }));
      plot.focus();
      if (document.activeElement !== plot) complain('a plot takes no keys');
      press('+');
      if (marks.getAttribute('viewBox') === whole) complain('+ does not zoom');
      press('0');
      if (marks.getAttribute('viewBox') !== whole) complain('0 does not show the whole');
      press('ArrowRight');
      const chart = plot.closest('.chart');
      if (!chart.querySelector('.reading').textContent) complain('→ reads nothing off');
      press('Escape');
    }
    for (const button of document.querySelectorAll('.switch')) {
      const chart = button.closest('.chart'), own = [...chart.querySelectorAll('.marks [data-name]')].filter(path => path.dataset.name === button.textContent);
      button.click();
      if (!own.length || own.some(path => getComputedStyle(path).display !== 'none')) complain(`${button.textContent} does not switch off`);
      button.click();
      if (own.some(path => getComputedStyle(path).display === 'none')) complain(`${button.textContent} does not come back`);
    }
    if (performance.getEntriesByType('resource').length) complain('something was fetched');
    const tags = ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa', 'best-practice'];
    const { violations } = await axe.run(document, { runOnly: tags, resultTypes: ['violations'], preload: false, iframes: false });
    for (const { id, help, nodes } of violations) complain(`axe ${id}: ${help}: ${nodes.length} times, the first ${nodes[0].html.slice(0, 120)}`);
    parent.postMessage(`CHECKED ${plots.length} plots, ${texts().length} texts, at ${width} px, ${matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : 'light'}\n${said.join('\n')}\nEND`, '*');
  });
})();
